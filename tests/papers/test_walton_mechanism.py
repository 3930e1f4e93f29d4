"""Judges of restitution and of how flows work: verdicts on made-up flows with known answers."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from sim.papers.walton.judges.mechanism import w29, w30, w31, w32
from sim.papers.walton.judges.restitution import w16, w27, w28
from tests.made.chute_flows import PACKING, SIZE, SLOPE, UNIT, base_flows, flow
from tests.made.results import checks_of, letters

RESTITUTIONS = (0.7, 0.85, 0.95)


def filled(z):
    return PACKING * (z < 6 * SIZE)


def agitated(shares, n=5, loud=(1, 1, 1), cell=10):
    """Return flows along e: T_z from three to four diameters up as shares of that near the plane.

    That of the bottom layer, and of what is far above, does not count; ``loud`` is that of all.
    """

    def temperature(z, share, level):
        far, near = (z > 3 * SIZE) & (z < 4 * SIZE), (z > SIZE) & (z < 2 * SIZE)
        return level * np.where(far, share, np.where(near, 1.0, 50 / level))

    return [
        flow(
            8,
            profiles={
                "vertical_temperature_profile": partial(temperature, share=share, level=level),
                "packing_profile": filled,
            },
            depth=n,
            restitution=e,
            cell=cell,
        )
        for e, share, level in zip(RESTITUTIONS, shares, loud, strict=True)
    ]


def losing(powers, n=5):
    """Return flows along e that lose powers (W) in collisions, and as much in friction."""
    return [
        flow(8, {"normal_power": p, "frictional_power": p}, depth=n, restitution=e)
        for e, p in zip(RESTITUTIONS, powers, strict=True)
    ]


def resilient(speeds=(13, 9, 7), depths=(1.4, 2, 2.9), n=5, **options):
    """Return flows at one depth along the restitution."""
    return [
        flow(speed, {"shear_depth": depth * SIZE}, depth=n, restitution=e, **options)
        for e, speed, depth in zip(RESTITUTIONS, speeds, depths, strict=True)
    ]


def rolling(*ratios):
    """Return flows of depths 5, 10, 20, whose bottom layer spins; a shallow one may slide."""
    flows = [
        flow(15, {"base_rolling": ratio}, **riding(n), depth=n, cell=5)
        for n, ratio in zip((5, 10, 20), ratios, strict=False)
    ]
    return [flow(5, {"base_rolling": 0.1}, **riding(2.5), depth=2.5, cell=5), *flows]


def riding(n):
    return {
        "profiles": {
            "velocity_profile": lambda z: UNIT * z / SIZE,
            "packing_profile": lambda z: PACKING * (z < n * SIZE),
        }
    }


def dissipating(*heights, friction=1.0):
    """Return stiff flows of four depths that lose energy evenly up to heights in diameters."""

    def loss(z, height, factor):
        return factor * (z < height * SIZE)

    return [
        flow(
            20,
            profiles={
                "normal_dissipation_profile": partial(loss, height=height, factor=1.0),
                "frictional_dissipation_profile": partial(loss, height=height, factor=friction),
                "packing_profile": lambda z, n=n: PACKING * (z < n * SIZE),
            },
            depth=n,
            cell=5,
            stiffness=1000,
        )
        for n, height in zip((5, 10, 20, 40), heights, strict=True)
    ]


def ending(faster=0.0, denser=0.0, layer=1, replicates=8, depths=(1.24, 2.5, 5), others=()):
    """Return flows one of whose layers is faster or denser at the end, by shares of the largest."""

    def profiles(n, faster, denser):
        def velocity(z, share=0.0):
            return UNIT * (z / SIZE + 4 * share * is_layer(z))

        def packing(z, share=0.0):
            return PACKING * (z < 4 * SIZE) * (1 + share * is_layer(z))

        return {
            "velocity_profile": velocity,
            "velocity_profile_instantaneous": partial(velocity, share=faster),
            "packing_profile": packing,
            "packing_profile_instantaneous": partial(packing, share=denser),
        }

    def is_layer(z):
        return (z > layer * SIZE) & (z < (layer + 1) * SIZE)

    return [
        flow(8, profiles=profiles(n, *change), depth=n, replicates=replicates)
        for places, change in ((depths, (faster, denser)), (others, (0.0, 0.0)))
        for n in places
    ]


def half_layer(share, speed=60, **options):
    """Return a flow of half a layer that loses a share of what gravity gives it."""
    (usual,) = base_flows({0.5: speed}, **options)
    power = share * usual.scalars["normal_power"].mean()
    return [flow(speed, {"normal_power": power, "frictional_power": power}, depth=0.5, **options)]


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (w16, "aR", lambda: resilient()),
    (w16, "aN", lambda: resilient(speeds=(7, 9, 13))),
    (w16, "aN", lambda: resilient(depths=(3, 2, 1.5))),
    (w16, "aI", lambda: resilient(speeds=(9, 9, 9))),
    (w16, "-", lambda: resilient(replicates=1)),
    (w27, "aR", lambda: agitated((0.2, 0.3, 0.4))),
    # Agitation that falls everywhere may still reach farther, and the other way round.
    (w27, "aR", lambda: agitated((0.2, 0.3, 0.4), loud=(9, 3, 1))),
    (w27, "aN", lambda: agitated((0.4, 0.3, 0.2), loud=(1, 3, 9))),
    (w27, "aI", lambda: agitated((0.3, 0.3, 0.3))),
    (w27, "aR bN", lambda: [*agitated((0.2, 0.3, 0.4)), *agitated((4, 3, 2), n=10, cell=5)]),
    (w27, "-", lambda: agitated((0.2, 0.3, 0.4))[1:]),
    (w28, "R", lambda: losing((1, 2, 3))),
    (w28, "N", lambda: losing((3, 2, 1))),
    # Flows that lose more for being deeper are not compared.
    (w28, "R", lambda: [*losing((1, 2, 3)), *losing((0.1, 0.2, 0.3), n=2.5)]),
    (w28, "I", lambda: losing((2, 2, 2))),
    (w28, "-", lambda: losing((1, 2, 3))[1:]),
    (w29, "aR bR cR dR", lambda: rolling(0.98, 0.97, 0.95)),
    (w29, "aR bR cR dN", lambda: rolling(0.7, 0.6, 0.6)),
    (w29, "aR bR cN dN", lambda: rolling(0.98, 0.95, 0.3)),
    (w29, "aR bR cI dN", lambda: rolling(0.7, 0.6, 0.5)),
    (w29, "-", lambda: rolling(0.98, 0.97, [0.95, 0.95, np.nan, 0.95, 0.95])),
    (w29, "-", lambda: rolling(0.98, 0.97)),
    (w30, "R", lambda: dissipating(3, 3, 3, 3)),
    (w30, "R", lambda: dissipating(3, 4, 5, 6, friction=9)),
    (w30, "N", lambda: dissipating(1, 4, 12, 36)),
    (w30, "-", lambda: dissipating(3, 3, 3, 3)[1:]),
    (w30, "-", lambda: base_flows({5: 8, 10: 15, 20: 25, 40: 30}, stiffness=1000, cell=5)),
    (w31, "aR bR", lambda: ending()),
    (w31, "aN bR", lambda: ending(faster=0.1)),
    (w31, "aN bR", lambda: ending(faster=-0.1)),
    (w31, "aR bN", lambda: ending(denser=-0.1)),
    # What few spheres above the flow do does not count, nor what a fourth depth does.
    (w31, "aR bR", lambda: ending(denser=0.1, depths=(20,), others=(1.24, 2.5, 5))),
    (w31, "-", lambda: ending(depths=(1.24, 2.5))),
    (w31, "aI bI", lambda: ending(replicates=2, faster=0.045, denser=0.049)),
    (w32, "R", lambda: half_layer(0.05)),
    (w32, "N", lambda: half_layer(0.15)),
    (w32, "I", lambda: half_layer(np.array([0.06, 0.13, 0.09, 0.12, 0.08]))),
    (w32, "-", lambda: half_layer(0.05, replicates=1)),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts


def drifting(point):
    """Return a point as if it gained a tenth of g sin θ."""
    return replace(point, scalars=point.scalars | {"acceleration": np.full(5, 0.1 * SLOPE)})


@pytest.mark.parametrize(
    ("judge", "points"),
    [(w16, resilient()), (w27, agitated((0.2, 0.3, 0.4))), (w28, losing((1, 2, 3)))],
)
def test_flows_that_have_not_settled_decide_nothing(judge, points):
    assert letters(judge, points) == ("R" if judge is w28 else "aR")
    moved = [points[0], drifting(points[1]), points[2]]
    assert letters(judge, moved) == ("-" if judge is w28 else "aI")


def test_depths_whose_flows_have_not_settled_are_left_out_of_the_losses():
    first, *others = losing((3, 2, 1), n=2.5)
    assert letters(w28, [*losing((1, 2, 3)), drifting(first), *others]) == "R"


def test_the_part_of_the_bed_that_loses_is_that_of_its_spheres():
    values = {
        check.points[0]: check.value for check in checks_of(w30, dissipating(2.5, 5, 10, 20))[1:]
    }
    assert list(values.values()) == pytest.approx([0.45] * 4, abs=0.01)
