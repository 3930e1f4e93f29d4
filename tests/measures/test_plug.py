"""States of a plug: their shares and lifetimes, from made-up time series."""

import numpy as np
import pytest
import xarray as xr

from sim.measures.layers import STATES, plug_states, spell_statistics

SIZE, GRAVITY = 1e-3, 10.0
UNIT = np.sqrt(SIZE / GRAVITY)
HEIGHT = (np.arange(48) + 0.5) * 0.25 * SIZE
PACKING = 0.6 * (HEIGHT < 10 * SIZE)
VELOCITY = {"plug": np.minimum(HEIGHT / (2 * SIZE), 1.0), "shear": HEIGHT / SIZE}


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
        "diameter": SIZE,
        "gravity": GRAVITY,
    }
    if plugs is not None:
        end, blocks = np.full(64, np.nan), len(plugs)
        end[:blocks] = (start + length * np.arange(1, blocks + 1)) * UNIT
        velocity, packing = (np.full((64, len(HEIGHT)), np.nan, np.float32) for _ in range(2))
        velocity[:blocks] = [VELOCITY["plug" if plug else "shear"] for plug in plugs]
        packing[:blocks] = PACKING
        data |= {
            "block_end": ("block", end),
            "velocity_profile_history": (("block", "height"), velocity),
            "packing_profile_history": (("block", "height"), packing),
        }
    time = 0.25 * UNIT * np.arange(1, len(number) + 1)
    return xr.Dataset(data, {"time": time, "height": HEIGHT})


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


@pytest.mark.parametrize("lifetime", [50.0, 200.0])
def test_the_lifetime_of_a_state_that_ends_at_random_is_found_again(lifetime):
    rng = np.random.default_rng(1)
    changes = rng.random(20_000) < 10.0 / lifetime
    inside = np.cumsum(changes) % 2 == 0
    share, time, endings = spell_statistics(inside, np.full(inside.size, 10.0))
    assert share == pytest.approx(0.5, abs=0.05)
    assert time / endings == pytest.approx(lifetime, rel=0.05)
