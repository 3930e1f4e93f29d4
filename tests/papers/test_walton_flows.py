"""Judges of flows as a whole: verdicts on correct, wrong, few or scattered synthetic flows."""

import numpy as np
import pytest

from sim.dataset.replicates import CLOSED_SHARE
from sim.papers.walton.judges.flows import w5, w9, w24, w26
from tests.made.chute_flows import SLOPE, SPEEDS, base_flows, flow
from tests.made.judging import headline_bounds, letters
from tests.made.results import made_point


def test_a_ledger_closes_as_caveats_demand():
    assert headline_bounds(w5) == {"max_missing": CLOSED_SHARE}


#: Values of a right flow at depth 5, a ledger that a replicate lacks, and no flow at all.
RIGHT = flow(8, depth=5).scalars
POWER, NORMAL, SHEAR = (RIGHT[n] for n in ("normal_power", "base_normal", "base_shear"))
LACKING = [1e-5, np.nan, 1e-5, 1e-5, 1e-5]
BELT = [made_point("belt", {"velocity": 0.1})]

#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (w5, "R", lambda: base_flows()),
    (w5, "N", lambda: [*base_flows(), flow(8, {"missing_energy": 0.006}, depth=5, friction=0.6)]),
    # A replicate without a ledger leaves the claim open.
    (w5, "I", lambda: [*base_flows(), flow(8, {"missing_energy": LACKING}, depth=5, friction=0.5)]),
    (w5, "-", lambda: BELT),
    (w9, "R", lambda: base_flows()),
    (w9, "N", lambda: base_flows(dict(zip(SPEEDS, range(20, 0, -2), strict=True)))),
    (w9, "I", lambda: base_flows(scatter=5, replicates=2)),
    (w9, "-", lambda: BELT),
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
    (w26, "R", lambda: base_flows()),
    (
        w26,
        "N",
        lambda: [*base_flows({1.24: 4.4}), flow(8, {"base_normal": 1.01 * NORMAL}, depth=5)],
    ),
    (w26, "N", lambda: [*base_flows({1.24: 4.4}), flow(8, {"base_shear": 1.01 * SHEAR}, depth=5)]),
    (w26, "I", lambda: base_flows(scatter=5, replicates=2)),
    (w26, "-", lambda: [flow(8.2, {"independent_samples": 1.0}, depth=5)]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
