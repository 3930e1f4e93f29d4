"""Measures of the belt, on motions with known measures."""

import numpy as np
import pytest
import xarray as xr

from sim.dataset.gather import column_means, cycle_means
from sim.measures.belt import backflow, is_at_phase_0, path_measures, series_measures
from tests.made.results import measured

BEAD = 1e-3


def ellipse(tilt, drift=0.0, major=2.0, minor=0.5, beads=30, steps=40):
    """Return paths (S, N, 2) in m on equal ellipses (semi-axes in mm) that drift (mm per cycle)."""
    phase = 2 * np.pi * np.linspace(0, 1, steps + 1)[:, None]
    long, short = major * np.sin(phase), minor * np.cos(phase)
    x = long * np.cos(tilt) - short * np.sin(tilt) + drift * phase / (2 * np.pi)
    z = long * np.sin(tilt) + short * np.cos(tilt)
    starts = np.random.default_rng(0).uniform(0, 20, (beads, 2))
    return BEAD * (np.stack([x, z], axis=-1) + starts)


def on_the_belt(path, width=20.0):
    """Return a replicate with a path, on a belt of ``width`` diameters."""
    return {"path": path, "diameter": BEAD, "width": width}


@pytest.mark.parametrize(("tilt", "drift"), [(0.3, 0.0), (np.pi / 2, 4.0), (2.5, -1.0)])
def test_axes_tilt_and_drift_of_an_ellipse(tilt, drift):
    values = path_measures(on_the_belt(ellipse(tilt, drift)))
    assert values["path_drift"] == pytest.approx(drift * BEAD, abs=1e-12)
    assert values["path_major"] == pytest.approx(2 * BEAD / 2**0.5)
    assert values["path_minor"] == pytest.approx(0.5 * BEAD / 2**0.5)
    assert values["path_tilt"] == pytest.approx(tilt)


def test_the_height_of_paths_counts_each_bead_by_itself():
    path = ellipse(np.pi / 2, minor=0.0)
    assert path_measures(on_the_belt(path))["path_vertical"] == pytest.approx(2 * BEAD / 2**0.5)
    # Half of the beads the other way round: no mean path, but the same height.
    mixed = path.copy()
    mixed[:, ::2, 1] = 2 * path[0, ::2, 1] - path[:, ::2, 1]
    values = path_measures(on_the_belt(mixed))
    assert values["path_vertical"] == pytest.approx(2 * BEAD / 2**0.5)
    assert values["path_major"] == pytest.approx(0, abs=1e-9)


def test_the_height_far_from_the_middle_counts_beads_by_their_mean_places():
    phase = 2 * np.pi * np.linspace(0, 1, 41)
    # Two turns of the belt on, or one back, a bead is where it was.
    middle = BEAD * np.array([1.0, 10.0, 14.0, 46.0, 30.0, -1.0])
    height = BEAD * np.array([1.0, 2.0, 2.0, 1.0, 2.0, 1.0])
    path = np.stack(np.broadcast_arrays(middle, height * np.sin(phase)[:, None]), axis=-1)
    far = path_measures(on_the_belt(path, width=20.0))["path_vertical_far"]
    assert far == pytest.approx(BEAD / 2**0.5)
    assert np.isnan(path_measures(on_the_belt(path, width=10.0))["path_vertical_far"])


def test_backflow_counts_beads_not_squares():
    velocity = np.array([[0.1, -0.1], [0.2, np.nan]])
    density = np.array([[3.0, 1.0], [1.0, 0.0]])
    field = {"field_velocity": velocity, "field_density": density}
    assert backflow(field) == pytest.approx(0.2)
    assert backflow(field | {"field_velocity": np.abs(velocity)}) == 0


def make_run():
    """Return one replicate of 30 cycles at 20 Hz with 4 samples each, averaged from cycle 20 on.

    At the beginning of a cycle there are fewer beads near the belt and weaker waves.
    """
    usual = {"frequency": 20.0, "width": 20.0, "diameter": BEAD}
    usual |= {"samples_per_cycle": 4, "average_start": 1.0}
    sample = np.arange(1, 121)
    time, less = sample / 80, np.where(sample % 4 == 0, 0.5, 1.0)
    waves = np.where(time <= 0.5, 5.0, np.where(time > 1.0, 2.0, 3.0))
    return xr.Dataset(
        {
            "belt_phase": ("time", 0.5 * np.pi * (sample % 4)),
            "base_occupancy": ("time", less * np.where(time > 1.0, 0.4, 0.8)),
            "wave_power": ("time", less * waves),
            "path": (("path_time", "particle", "axis"), ellipse(0.5, beads=5)),
            **{name: ((), value) for name, value in usual.items()},
        },
        coords={"time": time},
    )


def test_series_are_averaged_over_the_window_and_the_first_cycles():
    values = measured(make_run(), "belt")
    assert values["base_occupancy"] == pytest.approx(0.4 * 7 / 8)
    assert values["base_occupancy_at_phase_0"] == pytest.approx(0.2)
    assert values["wave_power"] == pytest.approx(2.0 * 7 / 8)
    assert values["wave_power_at_phase_0"] == pytest.approx(1.0)
    assert values["early_wave_power"] == pytest.approx(5.0 * 7 / 8)
    assert 0 < values["path_vertical_far"] == pytest.approx(values["path_vertical"])
    assert measured(xr.Dataset(), "belt") == {} and not column_means(xr.Dataset())


def test_the_force_on_the_belt_lies_about_the_middle_of_the_intervals_in_which_it_acts():
    """The belt is pressed in the last two of four intervals of a cycle, after the transient."""
    run = make_run()
    pressed = np.isin(np.arange(1, 121) % 4, (3, 0))
    late = run["time"].values > 1.0
    run["belt_normal_force"] = "time", np.where(late, pressed, 1.0)
    run["belt_contact_time"] = "time", np.where(late, np.where(pressed, 1.0, 0.2), 1.0)
    values = measured(run, "belt")
    assert values["belt_force_phase"] == pytest.approx(1.5 * np.pi)
    assert values["belt_contact_time"] == pytest.approx(0.6)
    assert "belt_force_phase" not in measured(make_run(), "belt")


def test_over_the_cycle_each_moment_has_the_mean_of_its_samples_in_the_window():
    """Two replicates of three cycles of four samples, the first cycle before the window."""
    phase = np.tile([0.5, 1.0, 1.5, 2.0], 3) * np.pi % (2 * np.pi)
    force = np.array([[9.0] * 4 + [1, 2, 3, 4] + [3, 4, 5, 8], [9.0] * 4 + [np.nan] * 8])
    over_time = ("replicate", "time")
    run = xr.Dataset(
        {name: (over_time, force) for name in ("belt_normal_force", "belt_shear_force")}
        | {"belt_contact_time": (over_time, force / 10), "belt_phase": (over_time, [phase] * 2)},
        coords={"time": np.arange(1, 13) / 4},
    ).assign(samples_per_cycle=4, average_start=("replicate", [1.0, 1.0]))
    values = cycle_means(run)
    # The interval about phase 0 ends a quarter turn after phase -π/2: it is the last sample's.
    assert values["cycle_phase"] == pytest.approx(np.array([-0.25, 0.25, 0.75, 1.25]) * np.pi)
    assert values["cycle_normal_force"][0] == pytest.approx([6.0, 2.0, 3.0, 4.0])
    assert np.isnan(values["cycle_normal_force"][1]).all()
    assert values["cycle_contact_time"][0] == pytest.approx([0.6, 0.2, 0.3, 0.4])
    assert not cycle_means(xr.Dataset())


def test_a_cycle_begins_at_the_sample_nearest_to_the_belts_mean_height_on_its_way_up():
    phase = np.radians([0, 17, 90, 180, 270, 300, 316, 359.9])
    values = is_at_phase_0(phase, 4)
    assert values.tolist() == [True, True, False, False, False, False, True, True]


def test_a_window_without_the_beginning_of_a_cycle_says_nothing_of_it():
    values = series_measures(make_run().isel(time=[0, 1, 81, 82]))
    assert np.isnan(values["base_occupancy_at_phase_0"])
    assert np.isnan(values["wave_power_at_phase_0"])


def test_columns_weigh_levels_by_their_beads():
    field = xr.Dataset(
        {
            "field_velocity": (("replicate", "column", "level"), [[[0.1, 0.4], [np.nan, np.nan]]]),
            "field_density": (("replicate", "column", "level"), [[[2e6, 1e6], [0.0, 0.0]]]),
        },
        coords={"column": [0.5e-3, 1.5e-3], "level": [0.0, 1e-3]},
    )
    values = column_means(field)
    assert values["column_velocity"][0] == pytest.approx([0.2, np.nan], nan_ok=True)
    assert values["column_density"][0] == pytest.approx([3e3, 0.0])
    assert values["column"] == pytest.approx([0.5e-3, 1.5e-3])
