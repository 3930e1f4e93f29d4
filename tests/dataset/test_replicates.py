"""Replicates told together: means, regimes and qualities, and the caveats of a run."""

import netCDF4
import numpy as np
import pytest

from sim.dataset.gather import measures, read_run
from sim.dataset.replicates import (
    caveats,
    layer_orders,
    outcome,
    pooled_half_width,
)
from sim.engine.stored_run import RunFile, summary_of
from sim.parameters import BeltParameters, ChuteParameters, ConveyorParameters, amounts
from sim.report.runs import describe_run as describe
from sim.report.status import _read_ended
from tests.made.runs import HEIGHTS, write_run

#: 1 % of g sin θ at the paper's angle and the drift of a target of 2 % allow more than this (m/s²).
NONE = 1e-3


def point(regimes, velocities=None, slopes=0.0, slope_half_width=NONE, samples=50.0, **words):
    """A chute point of 10 s windows, one replicate per regime, at 1 m/s by default."""
    count = len(regimes)
    usual = {"quality": "reliable", "stopped": "length", "reason": "", "status": "completed"}
    numbers = {
        "velocity": velocities or [1.0] * count,
        "velocity_half_width": 1e-3,
        "acceleration": slopes,
        "acceleration_half_width": slope_half_width,
        "independent_samples": samples,
        "average_start": 10.0,
        "steps": 20_000.0,
        "time_step_used": 1e-3,
    }
    return (
        {name: np.full(count, word, object) for name, word in (usual | words).items()}
        | {name: np.broadcast_to(np.asarray(x, float), count) for name, x in numbers.items()}
        | {"regime": np.array(regimes, object)}
        | {"system": "chute", "target": 0.02, "gravity": 9.81, "angle": 17.0}
    )


def test_slopes_that_scatter_as_each_run_knows_average_out():
    rng = np.random.default_rng(3)
    for count in (2, 8, 32):
        own = np.full(count, 1.96)
        found = np.array([pooled_half_width(rng.normal(size=count), own) for _ in range(400)])
        assert np.median(found) == pytest.approx(1.96 / np.sqrt(count))


@pytest.mark.parametrize("between", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("count", [3, 6, 16])
def test_the_interval_of_a_slope_holds_however_much_replicates_differ(count, between):
    rng = np.random.default_rng([count, int(10 * between)])
    slopes = rng.normal(size=(1500, count)) * np.hypot(1.0, between)
    own = np.full(count, 1.96)
    held = [abs(one.mean()) < pooled_half_width(one, own) for one in slopes]
    assert np.mean(held) > 0.9


@pytest.mark.parametrize(
    ("regimes", "slopes", "together"),
    [
        (["steady"] * 2, 0.0, "steady"),
        (["undetermined"] * 3, 0.0, "steady"),
        (["accelerating"] * 2, 0.1, "accelerating"),
        (["steady", "accelerating"], [0.0, 0.5], "mixed"),
        (["arrested", "steady"], 0.0, "mixed"),
        (["arrested", "arrested"], 0.0, "arrested"),
        # It slows down.
        (["undetermined"] * 2, -0.1, "undetermined"),
        ([], 0.0, "failed"),
    ],
)
def test_the_regime_is_that_of_the_mean_slope(regimes, slopes, together):
    assert outcome(point(regimes, slopes=slopes))["regime"] == together
    to_the_left = point(regimes, velocities=[-1.0] * len(regimes), slopes=-np.asarray(slopes))
    assert outcome(to_the_left)["regime"] == together


def test_a_trend_that_single_runs_leave_open_is_decided_by_many():
    """Each replicate has its slope to ± 0.05; the negligible slope is 0.01 m/s²."""
    rng = np.random.default_rng(1)
    slopes = rng.normal(0, 0.05 / 1.96, 200)
    few, many = (
        outcome(point(["undetermined"] * n, slopes=slopes[:n], slope_half_width=0.05))
        for n in (2, 200)
    )
    assert (few["regime"], few["quality"]) == ("undetermined", "short")
    assert (many["regime"], many["quality"]) == ("steady", "reliable")


def test_samples_of_all_replicates_count_together():
    assert outcome(point(["undetermined"], samples=6.0))["regime"] == "undetermined"
    three = outcome(point(["undetermined"] * 3, samples=6.0))
    assert (three["regime"], three["quality"]) == ("steady", "reliable")


def test_a_mean_that_drifts_and_one_without_scatter_are_told():
    assert outcome(point(["undetermined"] * 2, slopes=-0.1))["quality"] == "drifting"
    rest = outcome(point(["arrested"] * 2, quality="jammed", samples=0.0))
    assert (rest["regime"], rest["quality"]) == ("arrested", "jammed")


PAPER = ChuteParameters()


def caveat_text(point=PAPER, **scalars):
    """Return the caveats of replicates that all completed."""
    count = max(map(len, scalars.values()), default=0)
    known = {"status": ["completed"] * count, "time_step_used": [point.time_step] * count}
    return caveats("", known | {"steps": [point.steps] * count} | scalars, point)


def test_flows_that_overlap_beyond_the_contact_law_say_so_once():
    assert caveat_text(max_overlap=[np.nan, 0.099]) == ""
    text = caveat_text(max_overlap=[0.05, 0.11, 0.2])
    assert text.startswith("spheres overlap by more than 10 % of a diameter")
    assert caveat_text(BeltParameters(), max_overlap=[0.6]) == ""


def test_runs_longer_than_is_asked_for_say_so():
    asked = PAPER.steps
    assert caveat_text(steps=[asked, 0.2 * asked, np.nan]) == ""
    assert caveat_text(steps=[asked, 1.1 * asked]).startswith("runs longer than is asked for")


def test_replicates_that_are_one_run_say_so():
    """Such as a sphere whose height and velocity are given; beds at rest may lack overlaps."""
    assert caveat_text(max_overlap=[0.03, 0.03]).startswith("replicates are the same to the bit")
    for overlaps in ([0.03], [0.03, 0.03, 0.031], [0.0, 0.0], [np.nan, np.nan]):
        assert caveat_text(max_overlap=overlaps) == ""


def test_a_study_that_asks_for_less_than_was_run_is_told_so(tmp_path):
    """It takes the first of several replicates, but cannot take a part of a longer run."""
    held = ChuteParameters(average=40, replicates=2)
    path = write_run(tmp_path, held, 0.5)
    for asked, is_longer in ((held, False), (ChuteParameters(average=10, replicates=1), True)):
        text = caveats("", summary_of(path, amounts(asked)).scalars, asked)
        assert text.startswith("runs longer") == is_longer


def test_a_start_faster_than_the_contact_law_bears_is_known_before_any_run():
    """At 100 N/m an impact at √(gσ) overlaps by 0.85 % of a diameter; half of V counts."""
    assert not ChuteParameters(initial_velocity=23.3).caveat
    assert "beyond the range" in ChuteParameters(initial_velocity=23.5).caveat
    assert not ChuteParameters(initial_velocity=70, stiffness=1000).caveat


def test_a_depth_that_whole_particles_do_not_have_is_known_before_any_run():
    """0.45 · 4² = 7.2 spheres become 7, and 2.9 discs become a row of 3."""
    assert ChuteParameters(depth=0.45, cell=4).caveat.startswith("whole particles in the cell")
    assert not ChuteParameters(depth=0.4375, cell=4).caveat
    assert ConveyorParameters(shape="disc", depth=0.97, cell=3).caveat
    both = ChuteParameters(depth=0.45, cell=4, initial_velocity=50).caveat
    assert both.startswith("impacts") and "; whole particles" in both


@pytest.mark.parametrize("acceleration", [0.0, 5.0])
def test_a_run_file_and_the_dataset_agree(tmp_path, acceleration):
    """The gain of a flow is turned over too: 1.5 % of the dissipation may be a small share."""
    point = ChuteParameters(replicates=2)
    mass = point.particles * point.mass
    arrays = {
        "energy_residual": ("replicate", [0.015, np.nan]),
        "frictional_power": ("replicate", [mass * 0.5, np.nan]),
        "normal_power": ("replicate", [mass * 0.5, np.nan]),
        "acceleration": ("replicate", [acceleration, np.nan]),
    }
    path = write_run(tmp_path, point, 0.5, failed=[1], arrays=arrays)
    text = caveats("", summary_of(path).scalars, point)
    assert bool(text) == (acceleration == 0)
    assert text == caveats("", read_run(path).values, point)


@pytest.mark.parametrize(
    ("values", "orders", "is_told"),
    [
        # Depth 12 on bumps of 1 σ at 24°: in a cell of 5 σ, 0.46 and 0.61 m/s in layers, in one of
        # 8 σ 0.19 and 0.24 m/s.
        ({"bumps": 1, "cell": 5}, [0.75, 0.79], True),
        ({"bumps": 1, "cell": 5}, [0.16, np.nan, 0.75], True),
        ({"bumps": 1, "cell": 5}, [0.16, 0.28], False),
        ({"bumps": 1, "cell": 5}, [np.nan], False),
        ({"bumps": 1, "cell": 8}, [0.79], False),
        ({"cell": 5}, [0.79], False),
    ],
)
def test_layers_on_bumps_in_a_narrow_cell_are_told(values, orders, is_told):
    text = caveat_text(ChuteParameters(depth=12, **values), layer_order=orders)
    assert text.startswith("on bumps in a cell narrower than 8 σ") == is_told == bool(text)


def test_the_order_of_layers_of_a_run_file_is_that_of_the_dataset(tmp_path):
    """In the dataset it is an observable; pages and `info` of a run file measure it."""
    point, number = ChuteParameters(bumps=1, cell=5, depth=12), 300
    place = 5e-3 * np.random.default_rng(1).random((1, 1, number, 3))
    place[..., 2] = point.diameter * (1 + np.arange(number) % 12)
    arrays = {
        "position": (("replicate", "frame", "particle", "axis"), place),
        "packing_profile": (("replicate", "height"), np.full((1, HEIGHTS), 0.5)),
    }
    path = write_run(tmp_path, point, 0.5, arrays=arrays)
    with netCDF4.Dataset(path) as file:
        measured = list(measures(RunFile(file))["layer_order"])
    orders = layer_orders(path, point)
    assert orders == measured == [pytest.approx(1, abs=1e-3)]
    for cell, is_narrow in (([8, 5], True), ([5, 8], True), (8, False)):
        other = ChuteParameters(bumps=1, cell=cell, depth=12)
        assert layer_orders(path, other) == (orders if is_narrow else [])
    assert "ordered in layers" in _read_ended(path, 0, point, None).caveat
    scalars = summary_of(path).scalars | {"layer_order": orders}
    assert "ordered in layers" in caveats("", scalars, point)
    assert "ordered in layers" in describe(path)
