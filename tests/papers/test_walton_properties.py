"""Judges of properties of the spheres: verdicts on correct, wrong, few or scattered flows."""

from dataclasses import replace

import numpy as np
import pytest

from sim.claims.evidence import Evidence
from sim.claims.verdict import INCONCLUSIVE, REPRODUCED
from sim.papers.walton.judges.properties import w15, w20, w21, w22
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
from tests.made.results import SCATTER, by_part, checks_of, letters, made_results


def ordered_flow(share, knee=2, rest=0.0, **options):
    """Return a flow with a crystalline share: a plug on ``knee`` diameters, or sheared."""
    scalars = {"crystalline_share": share, "layer_order": 0.6}
    profiles = riding(options["depth"], knee, rest, options.get("replicates", 5))
    return flow(15, scalars, profiles, **options)


def riding(depth, knee=2, rest=0.0, replicates=5):
    """Return profiles of a plug on ``knee`` diameters."""
    return {
        "velocity_profile": kinked_profile(knee, depth, rest, replicates),
        "packing_profile": lambda z: PACKING * (z < depth * SIZE / 0.9),
    }


def crystals(share=0.8, usual=0.8, spread=0.3, bumps=0.1, wide=0.6, rest=0.0, scatter=0.01):
    """Return stiff flows with crystalline plugs; a soft one, and its controls with weaker order."""
    options = {"scatter": scatter}
    narrow = {"depth": 10, "cell": 5} | options
    return [
        *(ordered_flow(share, depth=n, cell=5, stiffness=1000, **options) for n in (10, 20, 40)),
        ordered_flow(usual, **narrow),
        ordered_flow(spread, diameter_spread=0.1, rest=rest, **narrow),
        ordered_flow(bumps, bumps=1, **narrow),
        ordered_flow(wide, depth=10, cell=20, **options),
    ]


def soft(median=0.003, dynamic=0.05, static=None, replicates=5, **options):
    """Return flows of the softest spheres with quantiles of their overlaps."""
    options["replicates"] = replicates
    thin = {"median_overlap": median, "overlap_999": 0.025}
    deep = {"median_overlap": 0.003, "overlap_999": dynamic}
    rest = {"regime": "arrested", "quality": "jammed", "independent_samples": 0.0}
    flows = [
        *(flow(4.5, thin, depth=n, **options) for n in (1.24, 2.5)),
        flow(30, deep, riding(40, replicates=replicates), depth=40, **options),
    ]
    if static:
        flows += [flow(0, rest | {"base_overlap": static}, depth=40, angle=0, **options)]
    return flows


def stiff(slower=0.6, deeper=2.0, shallow=1.01, hotter=3.0, scatter=SCATTER, **options):
    """Return deep and shallow flows at two stiffnesses; arguments are ratios, stiff over soft."""
    points = []
    for n in (1.24, 2.5, 20, 40):
        for stiffness in (100, 1000):
            hard = stiffness == 1000
            speed = SPEEDS[n] * ((slower if n > 10 else shallow) if hard else 1)
            heat = 1e-4 * (hotter if hard else 1)
            points.append(
                flow(
                    speed,
                    {"shear_depth": (deeper if hard else 1) * SIZE},
                    {
                        "velocity_profile": kinked_profile(2, n, replicates=5),
                        "packing_profile": lambda z, n=n: PACKING * (z < n * SIZE),
                        # What moves in the bottom layer and high above it does not count.
                        "vertical_temperature_profile": lambda z, heat=heat: np.where(
                            (z > SIZE) & (z < 2 * SIZE), heat, 1.0
                        ),
                    },
                    depth=n,
                    stiffness=stiffness,
                    scatter=scatter,
                    **options,
                )
            )
    return points


def layer(heat, shear, knee=1.75):
    """Return a flow with a temperature and a shear rate (√(g/σ)) up to a height, in the layer."""
    profiles = {
        "velocity_profile": np.tile(shear * kinked_profile(knee, 20, replicates=1), (5, 1)),
        "packing_profile": lambda z: PACKING * (z < 20 * SIZE),
        "vertical_temperature_profile": lambda z: np.where(
            (z > SIZE) & (z < 2 * SIZE), heat * UNIT**2, 1.0
        ),
    }
    return Evidence(made_results(flow(25, profiles=profiles, depth=20, scatter=0)), "published")


def runaway(points, number: int):
    """Return points, one of them as if it ran away."""
    gain = np.full(5, 0.1 * SLOPE)
    scalars = points[number].scalars | {"acceleration": gain}
    return [*points[:number], replace(points[number], scalars=scalars), *points[number + 1 :]]


@pytest.mark.parametrize(
    ("judge", "points", "number", "part"),
    [
        (w15, crystals(), 2, "a"),
        (w15, crystals(), 4, "b"),
        (w20, soft(), 0, "a"),
        (w21, stiff(), 1, "a"),
        (w21, stiff(), 4, "b"),
        (w22, stiff(), 4, ""),
    ],
)
def test_flows_that_have_not_settled_decide_nothing(judge, points, number, part):
    assert by_part(checks_of(judge, points))[part] == REPRODUCED
    assert by_part(checks_of(judge, runaway(points, number)))[part] == INCONCLUSIVE


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (w15, "aR bR cR dR", lambda: crystals()),
    (w15, "aN bR cR dR", lambda: crystals(share=0.4)),
    (w15, "aR bN cR dR", lambda: crystals(spread=0.85)),
    (w15, "aR bR cN dR", lambda: crystals(bumps=0.85)),
    (w15, "aR bR cR dN", lambda: crystals(wide=0.85)),
    (w15, "aR bR cR", lambda: crystals()[:-1]),
    (w15, "-", lambda: base_flows({1.24: 4.4, 5: 8.2})),
    (w20, "aR bR", lambda: soft()),
    (w20, "aN bR", lambda: soft(median=0.011)),
    (w20, "aR bN", lambda: soft(dynamic=0.02)),
    (w20, "aR bR cR", lambda: soft(static=0.0056)),
    (w20, "aR bR cN", lambda: soft(static=0.02)),
    (w20, "aI bI", lambda: soft(scatter=0.8)),
    (w21, "aR bR", lambda: stiff()),
    (w21, "aR bN", lambda: stiff(slower=1.05)),
    (w21, "aR bN", lambda: stiff(deeper=0.9)),
    (w21, "aN bR", lambda: stiff(shallow=1.08)),
    (w21, "aI bI", lambda: stiff(slower=1, shallow=1.03, scatter=0.5)),
    (w21, "-", lambda: base_flows({1.24: 4.4, 5: 8.2})),
    (w22, "R", lambda: stiff()),
    (w22, "N", lambda: stiff(hotter=0.8)),
    (w22, "I", lambda: stiff(hotter=1.0)),
    (w22, "-", lambda: base_flows({1.24: 4.4, 5: 8.2})),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
