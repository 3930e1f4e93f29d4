"""Judges of regimes and of flows as a whole, on synthetic flows."""

from math import radians, tan

import numpy as np
import pytest

from sim.dataset.replicates import CLOSED_SHARE
from sim.papers.walton.judges.chute import CELLS
from sim.papers.walton.judges.flows import w5, w9, w23, w24
from sim.papers.walton.judges.regimes import w6, w7, w8, w19, w25
from tests.made.chute_flows import PAPER, SLOPE, SPEEDS, WIDE, base_flows, flow
from tests.made.results import headline_bounds, letters, made_boundary, made_point

TANGENT = tan(radians(PAPER.angle))


def accelerating(gain: float, error: float = 1e-3, speed: float = 60, **options):
    """Return a flow with dV/dt in g sin θ, known within a standard error."""
    trend = {
        "acceleration": gain * SLOPE,
        "acceleration_error": error * SLOPE,
        "acceleration_half_width": WIDE * error * SLOPE,
        "regime": "accelerating",
    }
    return flow(speed, trend, **options)


def slippery(change: float = 1.0, error: float = 1e-3, depths=(0.5, 10, 40)):
    """Return flows that slide as a block does, but for a factor at depth 10."""
    return [
        accelerating((change if n == 10 else 1) * (1 - mu / TANGENT), error, friction=mu, depth=n)
        for mu in headline_bounds(w6)["frictions"]
        for n in depths
    ]


def from_two_seeds(low: float) -> list[dict[str, object]]:
    return [
        made_boundary("chute", "acceleration", "depth", low, low + 0.1, seed=seed)
        for seed in (1, 2)
    ]


RESTING = {
    "regime": "arrested",
    "quality": "jammed",
    "independent_samples": 0.0,
    "transient_end": 0.5,
}


def swept(steady=(0.32, 0.4), arrested=(0.65, 0.8), moving=(), depth=5, starts=(0.5, 1.0)):
    """Return a sweep of friction at one depth; rough flows are started slowly."""
    return [
        *(flow(8, friction=mu, depth=depth, cell=CELLS[depth]) for mu in steady),
        *(
            flow(speed, rest, friction=mu, depth=depth, cell=CELLS[depth], initial_velocity=start)
            for frictions, speed, rest in ((arrested, 1e-5, RESTING), (moving, 3, None))
            for mu in frictions
            for start in starts
        ),
    ]


def sweeps(running=(), depths=(1.24, 5, 10)):
    """Return sweeps at several depths, of which some flows run away just above tan θ."""
    return [
        *(point for n in depths for point in swept(depth=n)),
        *(accelerating(0.05, friction=0.35, depth=n, cell=CELLS[n]) for n in running),
    ]


def started(late: float = 1.0, scatter: float = 1e-3, depths=(2.5, 5), scalars=None):
    """Return flows after three starts; the fast start has its own velocity and ``scalars``."""
    return [
        flow(
            SPEEDS[n] * (late if start == 2 else 1),
            scalars if start == 2 else None,
            depth=n,
            cell=CELLS[n],
            initial_velocity=start * SPEEDS[n],
            scatter=scatter,
            replicates=8,
        )
        for n in depths
        for start in (0.5, 1, 2)
    ]


def windows(rest: float, runaway: float, width: float = 0.25, depths=(5, 10), seeds=(1, 2)):
    return [
        made_boundary("chute", of, "angle", low, low + width, depth=n, seed=seed)
        for n in depths
        for seed in seeds
        for of, low in (("flow", rest), ("acceleration", runaway))
    ]


#: Velocities at all depths but one between the first and the second layer.
OTHERS = {depth: speed for depth, speed in SPEEDS.items() if depth != 1.5}


def test_a_ledger_closes_as_caveats_demand():
    assert headline_bounds(w5) == {"max_missing": CLOSED_SHARE}


#: Values of a right flow at depth 5, a ledger that a replicate lacks, and no flow at all.
RIGHT = flow(8, depth=5).scalars
POWER = RIGHT["normal_power"]
LACKING = [1e-5, np.nan, 1e-5, 1e-5, 1e-5]
BELT = [made_point("belt", {"velocity": 0.1})]


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (w6, "R", lambda: slippery()),
    (w6, "N", lambda: slippery(0.8)),
    # A gain within five errors of none decides nothing.
    (w6, "I", lambda: slippery(error=0.005)),
    (w7, "R", lambda: [accelerating(5 / 7, depth=0.5)]),
    (w7, "N", lambda: [accelerating(0.85, depth=0.5)]),
    (w7, "N", lambda: [flow(40, depth=0.5)]),
    # Watched for too short a time.
    (w7, "I", lambda: [accelerating(5 / 7, speed=40, depth=0.5)]),
    (w8, "R", lambda: (base_flows(), from_two_seeds(0.7))),
    (w8, "N", lambda: [*base_flows(OTHERS), accelerating(0.02, 1e-3, 4.5, depth=1.5)]),
    (w8, "N", lambda: [*base_flows(OTHERS), flow(5.2, depth=1.5)]),
    (w8, "I", lambda: base_flows(scatter=0.2)),
    (w8, "I", lambda: [*base_flows(OTHERS), flow(4.5, {"independent_samples": 1.0}, depth=1.5)]),
    (w8, "-", lambda: base_flows(average=50)),
    (w19, "aR bR", lambda: sweeps()),
    (w19, "aN bR", lambda: sweeps((5, 10, 20), (1.24, 2.5, 5, 10, 20))),
    (
        w19,
        "aR bN",
        lambda: [flow for n in (1.24, 5, 10) for flow in swept((0.32, 0.4), (), (0.65,), n)],
    ),
    # Where two depths were run, a third may be steady or not.
    (w19, "aI bR", lambda: sweeps((), (1.24, 5))),
    (w23, "aR bR cR", lambda: started(depths=(2.5, 5, 10))),
    (w23, "aN bN cN", lambda: started(1.05, depths=(2.5, 5, 10))),
    (w23, "aI bI cI", lambda: started(scatter=0.05, depths=(2.5, 5, 10))),
    (w23, "aR bR cN", lambda: [*started(), *started(1.2, depths=(10,))]),
    (w25, "R", lambda: (base_flows({5: 8}), windows(13, 20))),
    (w25, "N", lambda: (base_flows({5: 8}), windows(16, 16.25))),
    (w25, "N", lambda: (base_flows({5: 8}), windows(18, 17))),
    # How much starts differ is not known.
    (w25, "I", lambda: (base_flows({5: 8}), windows(13, 20, seeds=(1,)))),
    (w25, "-", lambda: (base_flows({5: 8}), windows(13, 20, depths=(5, 20)))),
    (w5, "R", lambda: base_flows()),
    (w5, "N", lambda: [*base_flows(), flow(8, {"missing_energy": 0.006}, depth=5, friction=0.6)]),
    # A replicate without a ledger leaves the claim open.
    (w5, "I", lambda: [*base_flows(), flow(8, {"missing_energy": LACKING}, depth=5, friction=0.5)]),
    (w9, "R", lambda: base_flows()),
    (w9, "N", lambda: base_flows(dict(zip(SPEEDS, range(20, 0, -2), strict=True)))),
    (w9, "I", lambda: base_flows(scatter=5, replicates=2)),
    (w24, "R", lambda: base_flows()),
    (
        w24,
        "N",
        lambda: [
            flow(8, {"normal_power": 1.98 * POWER, "frictional_power": 0.02 * POWER}, depth=5)
        ],
    ),
    (
        w24,
        "I",
        lambda: [
            flow(8, {"normal_power": POWER * np.array([1.0, 0.01, 0.01, 0.001, 0.01])}, depth=5)
        ],
    ),
    # A balance is one of steady flows, and of more than a run.
    (w24, "-", lambda: [flow(9, {"acceleration": 0.1 * SLOPE}, depth=7)]),
    (w24, "-", lambda: [flow(9, depth=7, replicates=1)]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
