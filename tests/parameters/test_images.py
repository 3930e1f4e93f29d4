"""The least cell is where no particle can touch two periodic images of another one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.base.errors import InputError
from sim.engine.systems import build
from sim.parameters import canonical_values, parse_point, point_id
from sim.parameters.images import largest_diameter, least_period
from tests.engine_motion.points import chute_point

SIZES = st.floats(0.5, 3)


def touched_images(across, up, period: float, reach: float):
    """Return how many images of a particle touch one that is so far ``across`` and ``up`` (n,)."""
    shifts = period * np.arange(-4, 5)
    return (np.hypot(across[:, None] + shifts, up[:, None]) < reach).sum(axis=1)


@given(SIZES, SIZES, st.floats(0, 0.5), st.floats(0.9, 1.1), st.integers(0, 10**6))
def test_two_images_can_be_reached_below_the_least_period_alone(
    largest, fixed, beyond, share, seed
):
    least = least_period(largest, fixed, beyond)
    period, rng = share * least, np.random.default_rng(seed)
    across = np.append(rng.uniform(-period, period, 500), 0.5 * period)
    up = np.append(rng.uniform(-least, least, 500), 0.0)
    for other in (fixed, largest, *rng.uniform(0, largest, 3)):
        most = touched_images(across, up, period, 0.5 * (largest + other) + beyond).max()
        assert most <= 1 or share < 1
    if share < 1:
        assert touched_images(across, up, period, 0.5 * least).max() == 2


@pytest.mark.parametrize("shape", ["disc", "sphere"])
@pytest.mark.parametrize(("bumps", "spread"), [(2.5, 0), (2, 0.5), (3, 0.3), (2.0001, 0)])
def test_a_cell_narrower_than_a_bump_and_the_largest_particle_is_refused(shape, bumps, spread):
    given_values = {"system": "conveyor", "shape": shape, "bumps": bumps, "diameter_spread": spread}
    least = bumps + largest_diameter(spread, shape == "disc")
    parse_point({**given_values, "cell": least + 1e-9}, "study.yaml")
    message = r"study.yaml: cell: got [\d.]+; allowed: at least bumps \+ the largest diameter = "
    with pytest.raises(InputError, match=message):
        parse_point({**given_values, "cell": max(3, least - 1e-6)}, "study.yaml")


@pytest.mark.parametrize("system", [pytest.param("chute", marks=pytest.mark.long), "conveyor"])
def test_largest_diameters_are_those_of_many_particles(system):
    values = {"system": system, "depth": 40, "cell": 10, "diameter_spread": 0.4}
    flow = build(parse_point(values | ({"shape": "disc"} if system == "conveyor" else {}), "p"), 0)
    largest = 2 * flow.spheres.radius.max() / flow.parameters.diameter
    assert largest == pytest.approx(largest_diameter(0.4, system == "conveyor"), rel=0.02)


def test_a_particle_too_large_among_few_is_refused_when_the_flow_starts():
    """The scale to the mean mass is that of the particles there are."""
    values = {"system": "chute", "cell": 3, "depth": 1, "diameter_spread": 0.5}
    build(parse_point({**values, "seed": 24}, "p"), 0)
    message = r"chute-.*: cell: got 3; allowed: at least twice the largest diameter = 3\.\d"
    with pytest.raises(InputError, match=message):
        build(parse_point({**values, "seed": 25}, "p"), 0)
    build(parse_point({**values, "seed": 25, "cell": 4, "depth": 9 / 16}, "p"), 0)


def test_the_other_ranges_keep_images_apart_by_themselves():
    """Without bumps, cells of spheres and discs; beads of a belt, and its obstacle."""
    for spread in (0, 0.25, 0.5):
        for is_flat in (False, True):
            assert least_period(largest_diameter(spread, is_flat)) < 3
    for width in (5, 6, 20, 1000):
        obstacle = width - 3 - 1e-6
        parse_point({"system": "belt", "width": width, "obstacle": obstacle}, "p")
        assert least_period(2, obstacle) < width


def test_both_sides_of_a_cell_have_one_spelling_in_points():
    """A square one is the point that one number gives, so ids stay."""
    square, oblong = {"cell": [8, 8.0]}, {"cell": [8, 4]}
    for given_values in ({"cell": 8, "cell_across": 8}, square, {"cell": [8, 0]}):
        assert chute_point(**given_values) == chute_point(cell=8)
    assert chute_point(**oblong) == chute_point(cell=8, cell_across=4)
    assert point_id(chute_point(**oblong)) != point_id(chute_point(cell=8))
    p = chute_point(**oblong, depth=2)
    assert (p.particles, p.breadth, chute_point(cell=8).breadth) == (64, 4, 8)
    assert parse_point(canonical_values(p), "p") == p
