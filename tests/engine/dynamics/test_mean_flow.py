"""How long a list holds in a flow: the shear that it allows for."""

import numpy as np
import pytest

from sim.engine.dynamics import mean_flow
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.mean_flow import AGE, LEAST_PARTICLES, SLOPE
from sim.engine.dynamics.neighbors import empty_pair_list
from sim.engine.systems import leap_frog
from tests.engine_motion.helpers import RADIUS, compiled, lattice
from tests.engine_motion.spheres import SphereMotion

allowed_stray, set_stream = compiled(mean_flow.allowed_stray), compiled(mean_flow.set_stream)

FAR = 40 * RADIUS
BOX = make_box(FAR, FAR)


def shortening(strain):
    """The factor by which a shear shortens a distance at most."""
    return np.sqrt(1 + strain**2 / 4) - strain / 2


def test_no_shear_shortens_a_distance_by_more_than_its_factor():
    """|x + strain z e_x| against |x|; the bound is met, so there is no better one."""
    rng = np.random.default_rng(1)
    x = rng.normal(size=(20_000, 3))
    for strain in (0.0, 0.01, 0.1, 0.5, 1.0, 3.0):
        sheared_points = x.copy()
        sheared_points[:, 0] += strain * rng.uniform(-1, 1, len(x)) * x[:, 2]
        ratio = np.linalg.norm(sheared_points, axis=1) / np.linalg.norm(x, axis=1)
        assert ratio.min() >= shortening(strain) - 1e-14
        angle = np.linspace(0, np.pi, 10_001)
        sheared_lengths = np.hypot(np.cos(angle) + strain * np.sin(angle), np.sin(angle))
        assert sheared_lengths.min() == pytest.approx(shortening(strain), abs=1e-6)


@pytest.mark.parametrize(("slope", "age"), [(0.0, 500), (300.0, 0), (300.0, 100), (-50.0, 300)])
def test_allowed_stray_is_half_of_what_the_shear_leaves_beyond_the_reach(slope, age):
    radius, skin, step = RADIUS * np.array([0.7, 1.2, 1.0]), 0.4e-3, 5e-6
    pairs = empty_pair_list(radius, BOX, skin)
    pairs.clock[AGE], pairs.clock[SLOPE] = age, abs(slope)
    reach, factor = 2.4 * RADIUS, shortening(abs(slope) * age * step)
    expected = 0.5 * ((reach + skin) * factor - reach)
    assert expected > 0.0
    assert allowed_stray(pairs, step) == pytest.approx(expected, rel=1e-12)


def test_a_list_sheared_beyond_its_skin_allows_for_no_stray_at_all():
    pairs = empty_pair_list(np.full(5, RADIUS), BOX, 0.1 * RADIUS)
    pairs.clock[AGE], pairs.clock[SLOPE] = 1000, 1000.0
    assert allowed_stray(pairs, 1e-5) == 0.0


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


@pytest.mark.parametrize("seed", range(5))
def test_stream_differs_between_two_heights_by_no_more_than_the_slope_allows(seed):
    """What the shear of the whole list stands for, in flows as irregular as one likes."""
    rng = np.random.default_rng(seed)
    height = rng.exponential(4 * RADIUS, 200) + FAR * (rng.random(200) < 0.05)
    pairs = list_with_stream(height, rng.normal(0, 0.3, 200) + np.sin(height / RADIUS))
    assert pairs.stream.any()
    height_differences = np.abs(np.subtract.outer(height, height))
    stream_differences = np.abs(np.subtract.outer(pairs.stream, pairs.stream))
    assert (stream_differences <= pairs.clock[SLOPE] * height_differences + 1e-12).all()


def test_too_few_particles_in_all_layers_but_one_make_no_stream():
    height = np.concatenate(
        [np.full(LEAST_PARTICLES, 0.1), 0.1 + 2.5 * RADIUS * np.arange(1, LEAST_PARTICLES)]
    )
    pairs = list_with_stream(height, 30.0 * height)
    assert not pairs.stream.any() and pairs.clock[SLOPE] == 0.0


def test_a_sheared_flow_without_agitation_keeps_its_list_until_the_shear_uses_up_the_skin():
    """Layers that slide over each other without touching: nothing strays from the mean flow."""
    rate, skin = 100.0, 0.3 * 2 * RADIUS
    position = lattice((4, 4, 5), 2.4 * RADIUS, 0.0, np.random.default_rng(0), FAR)
    velocity = np.zeros_like(position)
    velocity[:, 0] = rate * (position[:, 2] - position[:, 2].mean())
    motion = SphereMotion(position, velocity, box=(9.6 * RADIUS,) * 2, skin=skin).run(1)
    first_anchor, steps = motion.pairs.anchor.copy(), 1
    while np.array_equal(motion.pairs.anchor, first_anchor) and steps < 2000:
        motion.run(1)
        steps += 1
    factor = 2 * RADIUS / (2 * RADIUS + skin)
    strain = rate * steps * motion.time_step
    assert motion.flow.sums[leap_frog.CONTACTS] == 0.0
    assert strain == pytest.approx((1 - factor**2) / factor, rel=0.02)
    assert 2 * strain * 2.4 * RADIUS > 2 * skin
