"""How long a list holds in a flow: the shear that it allows for."""

import numpy as np
import pytest

from sim.engine.dynamics import mean_flow
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.mean_flow import AGE, SLOPE
from sim.engine.dynamics.neighbors import empty_pair_list
from tests.engine_motion.helpers import RADIUS, compiled

allowed_stray, set_stream = compiled(mean_flow.allowed_stray), compiled(mean_flow.set_stream)

FAR = 40 * RADIUS
BOX = make_box(FAR, FAR)


def shortening(strain):
    """The factor by which a shear shortens a distance at most."""
    return np.sqrt(1 + strain**2 / 4) - strain / 2


@pytest.mark.parametrize(("slope", "age"), [(0.0, 500), (300.0, 0), (300.0, 100), (-50.0, 300)])
def test_allowed_stray_is_half_of_what_the_shear_leaves_beyond_the_reach(slope, age):
    radius, skin, step = RADIUS * np.array([0.7, 1.2, 1.0]), 0.4e-3, 5e-6
    pairs = empty_pair_list(radius, BOX, skin)
    pairs.clock[AGE], pairs.clock[SLOPE] = age, abs(slope)
    reach, factor = 2.4 * RADIUS, shortening(abs(slope) * age * step)
    expected = 0.5 * ((reach + skin) * factor - reach)
    assert expected > 0.0
    assert allowed_stray(pairs, step) == pytest.approx(expected, rel=1e-12)
    pairs.clock[AGE], pairs.clock[SLOPE] = 2000, 1000.0
    assert allowed_stray(pairs, step) == 0.0


def list_with_stream(height, speed):
    """The list of spheres at these heights and speeds once it knows their flow."""
    pairs = empty_pair_list(np.full(len(height), RADIUS), BOX, 0.2 * RADIUS)
    set_stream(pairs, height, speed)
    return pairs


def test_stream_of_a_linear_profile_is_that_profile_relative_to_its_mean():
    height = np.random.default_rng(2).uniform(0, 10 * 2 * RADIUS, 500)
    speed = 0.3 + 40.0 * height
    pairs = list_with_stream(height, speed)
    assert pairs.clock[SLOPE] == pytest.approx(40.0, rel=1e-9)
    inside = (height > 2 * RADIUS) & (height < 9 * 2 * RADIUS)
    expected = speed - speed.mean()
    assert pairs.stream[inside] == pytest.approx(expected[inside], abs=1e-12)
    assert np.abs(pairs.stream - expected).max() < 40.0 * 2 * RADIUS


@pytest.mark.parametrize("seed", range(2))
def test_stream_differs_between_two_heights_by_no_more_than_the_slope_allows(seed):
    """What the shear of the whole list stands for, in flows as irregular as one likes."""
    rng = np.random.default_rng(seed)
    height = rng.exponential(4 * RADIUS, 200) + FAR * (rng.random(200) < 0.05)
    pairs = list_with_stream(height, rng.normal(0, 0.3, 200) + np.sin(height / RADIUS))
    assert pairs.stream.any()
    height_differences = np.abs(np.subtract.outer(height, height))
    stream_differences = np.abs(np.subtract.outer(pairs.stream, pairs.stream))
    assert (stream_differences <= pairs.clock[SLOPE] * height_differences + 1e-12).all()
