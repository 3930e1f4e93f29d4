"""Surface, shear layer, plug and its states, and the energy that a ledger lacks, of known flows."""

import numpy as np
import pytest
import xarray as xr

from sim.measures import layers
from sim.measures.layers import STATES, missing_energy, plug_states

SIZE = 1e-3
HEIGHT = (np.arange(80) + 0.5) * 0.25 * SIZE


def filled_profile(depth: float, packing: float = 0.6) -> np.ndarray:
    """Packing (H,) of a flow filled evenly up to a depth in diameters."""
    return packing * (depth * SIZE > HEIGHT)


def bent_profile(knee: float, top: float, rest: float = 0.0) -> np.ndarray:
    """Velocity (H,) that rises to ``top`` at ``knee`` diameters, then by ``rest`` per m."""
    z = HEIGHT / (knee * SIZE)
    return top * np.minimum(z, 1) + rest * np.maximum(HEIGHT - knee * SIZE, 0)


def test_surface_is_where_99_percent_of_the_mass_lies_below():
    assert layers.surface(HEIGHT, filled_profile(10)) == pytest.approx(9.9 * SIZE, rel=1e-9)
    flying = filled_profile(10) + 1e-4 * (HEIGHT > 15 * SIZE)
    assert layers.surface(HEIGHT, flying) == pytest.approx(9.9 * SIZE, rel=0.01)


def test_shear_depth_does_not_depend_on_spheres_that_fly_or_on_empty_slices():
    plain = layers.shear_depth(HEIGHT, bent_profile(4, 2.0), filled_profile(10), SIZE)
    assert plain == pytest.approx(3.6 * SIZE, rel=0.01)
    assert np.isnan(layers.shear_depth(HEIGHT, 0 * HEIGHT, filled_profile(10), SIZE))
    velocity = np.where(HEIGHT < 10 * SIZE, bent_profile(4, 2.0), 7.0)
    velocity[60:] = np.nan
    packing = filled_profile(10) + 1e-5 * ((HEIGHT > 12 * SIZE) & (HEIGHT < 15 * SIZE))
    depth = layers.shear_depth(HEIGHT, velocity, packing, SIZE)
    assert depth == pytest.approx(3.6 * SIZE, rel=0.01)


@pytest.mark.parametrize("knee", [2.0, 5.0])
def test_plug_begins_where_the_mean_shear_above_falls_below_a_twentieth(knee):
    base = layers.plug_base(HEIGHT, bent_profile(knee, 1.0), filled_profile(12), SIZE)
    assert (knee - 0.5) * SIZE < base <= (knee + 0.25) * SIZE


def test_flow_that_shears_throughout_has_no_plug():
    packing = filled_profile(12)
    base = layers.plug_base(HEIGHT, 100 * HEIGHT, packing, SIZE)
    assert base == layers.surface(HEIGHT, packing)
    shearing = bent_profile(2, 1.0, rest=0.1 * 1.0 / (2 * SIZE))
    assert layers.plug_base(HEIGHT, shearing, packing, SIZE) == base


def test_a_bulge_of_the_velocity_is_no_plug_though_its_sides_cancel():
    bulge = 0.3 * np.clip(1 - np.abs(HEIGHT / SIZE - 7) / 3, 0, None)
    base = layers.plug_base(HEIGHT, bent_profile(2, 1.0) + bulge, filled_profile(12), SIZE)
    assert base > 9 * SIZE


def test_layers_of_diameters_average_what_is_within():
    packing = filled_profile(8) * (1 + 0.3 * np.cos(2 * np.pi * HEIGHT / SIZE))
    assert layers.packing_by_diameters(HEIGHT, packing, SIZE) == pytest.approx([0.6] * 7)
    assert layers.packing_by_diameters(HEIGHT, packing, SIZE, layers=2) == pytest.approx([0.6] * 3)


DIAMETER, GRAVITY = 1e-3, 10.0
UNIT = np.sqrt(DIAMETER / GRAVITY)
HEIGHTS = (np.arange(48) + 0.5) * 0.25 * DIAMETER
PACKING = 0.6 * (HEIGHTS < 10 * DIAMETER)
VELOCITY = {"plug": np.minimum(HEIGHTS / (2 * DIAMETER), 1.0), "shear": HEIGHTS / DIAMETER}


def make_run(contacts, plugs=None, length=20.0, start=100.0) -> xr.Dataset:
    """A flow after ``start`` √(σ/g): contact numbers and plugs of blocks of some length each."""
    samples = round(4 * length)
    before = round(4 * start)
    number = np.concatenate([np.full(before, 9.0), np.repeat(np.asarray(contacts, float), samples)])
    data = {
        "contact_number": ("time", number),
        "velocity_profile": ("height", VELOCITY["plug"]),
        "packing_profile": ("height", PACKING),
        "average_start": start * UNIT,
        "diameter": DIAMETER,
        "gravity": GRAVITY,
    }
    if plugs is not None:
        end, blocks = np.full(64, np.nan), len(plugs)
        end[:blocks] = (start + length * np.arange(1, blocks + 1)) * UNIT
        velocity, packing = (np.full((64, len(HEIGHTS)), np.nan, np.float32) for _ in range(2))
        velocity[:blocks] = [VELOCITY["plug" if plug else "shear"] for plug in plugs]
        packing[:blocks] = PACKING
        data |= {
            "block_end": ("block", end),
            "velocity_profile_history": (("block", "height"), velocity),
            "packing_profile_history": (("block", "height"), packing),
        }
    time = 0.25 * UNIT * np.arange(1, len(number) + 1)
    return xr.Dataset(data, {"time": time, "height": HEIGHTS})


def test_shares_and_lifetimes_of_a_flow_that_passes_through_all_states():
    contacts = [1, 1, 3, 3, 3, 1, 1, 1, 1, 3]
    plugs = [1, 1, 1, 1, 1, 0, 0, 1, 1, 1]
    values = plug_states(make_run(contacts, plugs))
    assert [values[f"{state}_share"] for state in STATES] == pytest.approx([0.2, 0.4, 0.4])
    # Two spells of agitation ended, one of deep shear, and one of two locked ones.
    assert [values[f"{state}_endings"] for state in STATES] == [1, 2, 1]
    times = [values[f"{state}_time"] / UNIT for state in STATES]
    assert times == pytest.approx([40, 80, 80])
    # Blocks before the window do not count.
    run = make_run([3, 3, 1, 1], [1, 1, 1, 1])
    run["average_start"] = 140.0 * UNIT
    values = plug_states(run)
    assert values["agitated_share"] == 1.0 and values["agitated_endings"] == 0


def test_short_blocks_are_taken_together():
    """A plug that comes and goes within 10 √(σ/g) is not a state of its own."""
    contacts, plugs = [1] * 40, [1, 1, 1, 0] * 10
    values = plug_states(make_run(contacts, plugs, length=2.5))
    assert (values["deep_shear_share"], values["deep_shear_endings"]) == (1.0, 0)


def test_without_a_history_the_plug_is_that_of_the_window():
    values = plug_states(make_run([1, 1, 3, 3]))
    assert (values["agitated_share"], values["locked_share"]) == pytest.approx((0.5, 0.5))
    assert values["deep_shear_share"] == values["deep_shear_time"] == 0.0
    assert values["agitated_time"] == pytest.approx(40 * UNIT)
    assert (values["agitated_endings"], values["locked_endings"]) == (1, 0)
    run = make_run([3, 3, 1, 3])
    run["velocity_profile"] = "height", VELOCITY["shear"]
    assert plug_states(run)["deep_shear_share"] == 1.0


def test_a_window_of_less_than_a_spell_has_no_states():
    assert plug_states(make_run([1], length=9.0)) == {}
    assert plug_states(make_run([1]).drop_vars("contact_number")) == {}


def flow(**scalars) -> xr.Dataset:
    """Return ten spheres of 1 g at 2 m/s whose ledger lacks 0.8 % of the dissipated energy."""
    usual = {"particles": 10, "mass": 1e-3, "velocity": 2.0, "acceleration": 0.0}
    powers = {"frictional_power": 0.003, "normal_power": 0.001, "energy_residual": -0.008}
    return xr.Dataset(usual | powers | scalars)


#: What a flow has, and the share that it lacks.
FLOWS = {
    "steady": ({}, 0.008),
    # 10 g at 2 m/s that gain 0.6 m/s² take up 12 mW beside the 4 mW dissipated.
    "gains": ({"acceleration": 0.6}, 0.008 / 4),
    "loses": ({"acceleration": -0.6}, 0.008),
    "rests": ({"velocity": 0.0, "frictional_power": 0.0, "normal_power": 0.0}, 0.008),
}


@pytest.mark.parametrize("case", FLOWS)
def test_what_a_flow_gains_is_turned_over_as_well_as_what_it_dissipates(case):
    scalars, expected = FLOWS[case]
    assert missing_energy(flow(**scalars)) == pytest.approx(expected)


def test_belts_turn_over_what_the_file_says_and_files_without_a_ledger_nothing():
    assert missing_energy(flow().drop_vars("frictional_power")) == pytest.approx(0.008)
    assert np.isnan(missing_energy(flow().drop_vars("energy_residual")))
