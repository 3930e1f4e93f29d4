"""Judges of profiles: verdicts on correct, wrong, few or scattered synthetic flows."""

import numpy as np
import pytest

from sim.claims.verdict import INCONCLUSIVE, REPORTED
from sim.papers.walton.judges.profiles import w10, w11, w12, w13, w14, w17, w18
from tests.made.chute_flows import (
    PACKING,
    SIZE,
    SLOPE,
    SPEEDS,
    UNIT,
    base_flows,
    flow,
    kinked_profile,
)
from tests.made.results import SCATTER, checks_of, letters


def shaped(depth, velocity=lambda z: UNIT * z, packing=None, scalars=None, **options):
    """Return a flow of the base case with profiles: functions of height/diameter, or arrays."""

    def profile(shape):
        return (lambda height: shape(height / SIZE)) if callable(shape) else shape

    packing = packing or filled_to(depth / 0.9)
    profiles = {"velocity_profile": profile(velocity), "packing_profile": profile(packing)}
    return flow(SPEEDS[depth], scalars, profiles, depth=depth, **options)


def filled_to(depth: float):
    """Return the packing of a bed that is filled evenly up to a height in diameters."""
    return lambda z: PACKING * (z < depth)


def wavy(z, dip: float):
    """Return a velocity that rises but for a dip of its slope at one diameter."""
    return UNIT * (z - dip * np.clip(z - 1, 0, 0.5))


def thinning(z, bump: float):
    """Return a packing that falls with height, but for a bump in the upper half of layer two."""
    return np.clip(0.5 - 0.15 * z + bump * ((z > 1.5) & (z < 2)), 0, None)


def domed(z, peak: float, depth: float):
    """Return a packing with its maximum at half the depth, or its minimum if ``peak`` < 0."""
    inside = 0.5 + peak * np.sin(np.pi * z / depth)
    layers = 1 + 0.2 * np.cos(2 * np.pi * z)
    return np.where(z < depth, inside * layers, 0)


def block(plug: float = 0.62, sheared: float = 0.5, ripple: float = 0.0, gap: float = 1, **options):
    """Return a flow of stiff spheres at depth 40: a plug on a shear layer of four diameters.

    ``gap`` is the packing under the lowest centres over that of the shear layer.
    """

    def packing(z):
        rippled = plug * (1 + ripple * np.sign(np.sin(np.pi * z / 2)))
        layer = sheared * np.where(z < 0.5, gap, 1)
        return np.where(z < 4, layer, np.where(z < 60, rippled, 0))

    velocity = np.tile(kinked_profile(4.2, 40, replicates=1), (5, 1))
    return [shaped(40, velocity, packing, **{"transient": 2000, "stiffness": 1000} | options)]


def with_depths(*depths, scatter=SCATTER, **options):
    """Return flows of stiff spheres at three depths in cells of 5, with given shear depths."""
    options = {"stiffness": 1000, "cell": 5} | options
    return [
        shaped(n, scalars={"shear_depth": depth * SIZE}, scatter=scatter, **options)
        for n, depth in zip((10, 20, 40), depths, strict=True)
    ]


@pytest.mark.parametrize("judge", [w10, w12, w13, w18])
def test_a_flow_that_drifts_decides_nothing_on_profiles(judge):
    drift = {"acceleration": 0.1 * SLOPE}
    flows = [
        shaped(n, packing=filled_to(n + 3), replicates=8, scalars=drift)
        for n in (1, 1.24, 2, 3.5, 5, 10)
    ]
    verdicts = {check.verdict for check in checks_of(judge, flows)}
    assert verdicts - {REPORTED} == {INCONCLUSIVE}


def wavy_flows(dip, replicates=8, **rest):
    """Return thin flows with a dip; deeper ones may do as they like."""
    flows = [shaped(n, lambda z: wavy(z, dip), replicates=replicates, **rest) for n in (1.24, 2.5)]
    return [*flows, shaped(10, lambda z: -UNIT * z, replicates=8)]


def plugs(knee, rest=0.0):
    """Return deep flows that shear up to a height (at depth 10), and above it by a share."""
    return [shaped(n, kinked_profile(n / 10 * knee, n, rest), cell=10) for n in (10, 20, 40)]


def thinner(bump, **rest):
    """Return thin flows whose packing falls but for a bump; a deeper one may have any."""
    flows = ((1.24, bump), (2.5, 0.5))
    rest = {"replicates": 8} | rest
    return [shaped(n, packing=lambda z, b=b: thinning(z, b), **rest) for n, b in flows]


def domes(peak, **rest):
    """Return intermediate flows with a maximum of their packing inside."""
    depths = (3.5, 5, 10)
    return [shaped(n, packing=lambda z, n=n: domed(z, peak, 1.8 * n), **rest) for n in depths]


def slowest(velocity):
    """Return three flows, the slowest with a velocity over height."""
    return [shaped(1, velocity, filled_to(4)), shaped(1.24), shaped(2.5)]


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (w10, "R", lambda: wavy_flows(0.8)),
    (w10, "N", lambda: wavy_flows(1.2)),
    (w10, "I", lambda: wavy_flows(0.8, scatter=1.5)),
    (w10, "-", lambda: wavy_flows(0.8, replicates=5)),
    (w11, "R", lambda: plugs(2.0)),
    (w11, "N", lambda: plugs(2.0, 0.1)),
    (w11, "N", lambda: plugs(9.0)),
    (
        w11,
        "I",
        lambda: [
            shaped(10, kinked_profile(2, 10), cell=10),
            shaped(10, kinked_profile(2, 10, 0.2), initial_velocity=60),
        ],
    ),
    # A rise between slices is none between layers.
    (w12, "R", lambda: thinner(0.2)),
    (w12, "N", lambda: thinner(0.4)),
    (w12, "I", lambda: thinner(0.0, scatter=1.5)),
    (w12, "-", lambda: [shaped(1.24, packing=filled_to(1.5), replicates=8)]),
    (w13, "R", lambda: domes(0.1)),
    (w13, "N", lambda: domes(-0.1)),
    (w13, "I", lambda: domes(0.1, scatter=1.5)),
    (w13, "-", lambda: domes(0.1)[1:]),
    (w14, "R", lambda: block()),
    (w14, "N", lambda: block(plug=0.58)),
    (w14, "N", lambda: block(sheared=0.6, gap=0)),
    (w14, "N", lambda: block(plug=0.7, ripple=0.07)),
    (w14, "I", lambda: block(scatter=0.2)),
    (w14, "I", lambda: block(transient=300)),
    (w14, "-", lambda: base_flows({1.24: 4, 5: 8, 10: 15, 20: 25, 40: 30})),
    (w17, "aR bR", lambda: with_depths(3, 2, 1.5)),
    (w17, "aN bN", lambda: with_depths(1, 4, 30)),
    # A thicker layer may be a smaller fraction.
    (w17, "aN bR", lambda: with_depths(2.2, 2.4, 2.6)),
    (w17, "aI bI", lambda: with_depths(3, 2.9, 3.1, scatter=3)),
    (w17, "-", lambda: base_flows({1.24: 4, 5: 8, 10: 15, 20: 25, 40: 30})),
    (w18, "R", lambda: slowest(kinked_profile(1.5, 10, 0.1))),
    (w18, "N", lambda: slowest(kinked_profile(1.5, 10))),
    (w18, "I", lambda: slowest(lambda z: UNIT * (30 - z))),
    (w18, "-", lambda: slowest(kinked_profile(1.5, 10))[:2]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
