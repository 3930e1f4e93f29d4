"""Judges of flows as a whole: verdicts on correct, wrong, few or scattered synthetic flows."""

import numpy as np
import pytest

from sim.claims.verdict import (
    INCONCLUSIVE,
    REPRODUCED,
    combined_verdict,
)
from sim.dataset.replicates import CLOSED_SHARE
from sim.papers.walton.judges.flows import w5, w9, w24, w26
from tests.made.chute_flows import SLOPE, SPEEDS, base_flows, flow
from tests.made.judging import checks_of, failed_quantities, headline_bounds, letters
from tests.made.results import made_point


def test_a_ledger_closes_as_caveats_demand():
    assert headline_bounds(w5) == {"max_missing": CLOSED_SHARE}


def test_one_leaking_replicate_fails_the_ledger_wherever_it_is():
    leaking = flow(8, {"missing_energy": [1e-5, 0.006, 1e-5, 1e-5, 1e-5]}, depth=5, friction=0.5)
    checks = checks_of(w5, [*base_flows(), leaking])
    assert checks[0].value == pytest.approx(0.006) and checks[0].points == (leaking.id,)
    assert failed_quantities(checks) == [
        "largest share of the energy that a ledger lacks, 11 points"
    ]


def test_the_deepest_flow_counts_with_the_lowest_velocity_of_any_window():
    drift = {"acceleration": 0.1 * SLOPE}
    windows = [flow(v, drift, depth=40, transient=t) for v, t in ((50, 60), (3, 250))]
    others = base_flows({n: speed for n, speed in SPEEDS.items() if n < 40})
    single, bounded = (checks_of(w9, [*others, *more])[0] for more in (windows[:1], windows))
    assert single.value > bounded.value > 0
    assert single.verdict == REPRODUCED


def test_a_depth_counts_once_however_many_beds_it_has():
    """Replicates are no depths: four depths in order of six are as sure with 30 beds as with 3."""
    speeds = dict(zip((1.24, 1.5, 2.5, 5, 10, 20), (4, 5, 6, 7, 5.5, 4.5), strict=True))
    few, many = (
        checks_of(w9, base_flows(speeds, replicates=count, cell=10))[0] for count in (3, 30)
    )
    assert few.verdict == many.verdict == INCONCLUSIVE
    assert few.tested == many.tested
    # All of six in order: one of 720 orders.
    (rising,) = checks_of(w9, base_flows(dict(zip(speeds, range(4, 10), strict=True)), cell=10))
    assert rising.p_holds == pytest.approx(1 / 720, rel=1e-6)


def test_cells_are_not_mixed():
    """Flows in the narrow cell are twice as fast at any depth, which is no trend."""
    wide = base_flows({n: 8 + 0.1 * n for n in (1.24, 2.5, 5, 10)})
    narrow = [flow(v, depth=n, cell=5) for n, v in ((10, 19), (20, 18), (40, 17))]
    first, second = (
        checks_of(w9, [*more, flow(4, depth=1.5), flow(5, depth=2)])[0]
        for more in ([*wide, *narrow], [*wide, *narrow[1:]])
    )
    assert second.value > first.value


def test_the_sum_of_the_losses_is_shown_and_does_not_vote():
    right = flow(8, depth=5)
    power = {name: 0.9 * right.scalars[name] for name in ("normal_power", "frictional_power")}
    checks = checks_of(w24, [flow(8, power, depth=5)])
    assert combined_verdict(checks) == REPRODUCED
    assert checks[-1].value == pytest.approx(0.9) and not checks[-1].votes


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
