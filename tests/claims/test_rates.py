"""Error rates of the judges on synthetic flows; `python -m benchmarks.judging` has the table."""

import numpy as np
import pytest

from benchmarks.judging import (
    KINDS,
    STATEMENTS,
    dependence_rate,
    look_rates,
    majority_rates,
    rates,
    rates_by_replicates,
    steadiness,
)

#: Trials per rate; a rate must lie within the scatter of so many trials.
FEW, MANY = 25, 400


def at_most(share: float, trials: int) -> float:
    """Return the rate that one of a thousand sets of trials exceeds by chance."""
    return share + 3.1 * np.sqrt(share * (1 - share) / trials)


def test_what_is_true_by_two_half_widths_holds_and_what_is_false_does_not():
    reproduced, not_reproduced = rates("bound", "correlated", 3, 2, FEW)
    assert reproduced >= 0.8 and not_reproduced <= at_most(0.05, FEW)
    reproduced, _ = rates("bound", "correlated", 3, 0, FEW)
    assert reproduced <= at_most(0.05, FEW)


def test_a_claim_depends_on_readings_that_differ_and_hardly_on_others():
    """Two readings three half widths apart are noticed, and ten on one threshold are not."""
    assert dependence_rate(10, 0, 0, MANY) <= at_most(0.05, MANY)
    assert 1 - dependence_rate(2, 1.5, -1.5, MANY) <= at_most(0.2, MANY)


def test_looking_again_until_chance_decides_has_its_price():
    """On its threshold a value is open: whatever the judge says of it is wrong."""
    assert sum(look_rates(9, 0, False, MANY)) > 0.1
    assert sum(look_rates(9, 0, True, MANY)) <= at_most(0.05, MANY)
    held, failed = look_rates(9, 2, True, MANY)
    assert held > 0.95 and failed == 0


def test_steady_flows_are_steady_and_others_not():
    assert steadiness(0.0, 8, FEW)[0] >= 0.8
    assert steadiness(0.01, 8, FEW)[0] <= at_most(0.05, FEW)
    assert steadiness(0.03, 8, FEW)[1] >= 0.8


def test_a_share_of_half_is_not_often():
    reproduced, not_reproduced = majority_rates(0.5, 20, 400)
    assert max(reproduced, not_reproduced) <= at_most(0.05, 400)
    assert majority_rates(0.9, 20, 200)[0] >= 0.8


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("statement", STATEMENTS)
@pytest.mark.parametrize("replicates", [3, 8])
def test_rates_of_all_statements_on_all_flows(statement, kind, replicates):
    reproduced, not_reproduced = rates(statement, kind, replicates, 2, MANY)
    # An equality of flows in several states is nowhere so far from its margin.
    assert np.isnan(reproduced) or (reproduced >= 0.8 and not_reproduced <= at_most(0.05, MANY))
    for distance in (0, -1):
        reproduced, _ = rates(statement, kind, replicates, distance, MANY)
        assert reproduced <= at_most(0.05, MANY)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("statement", STATEMENTS)
def test_more_replicates_never_make_a_verdict_worse(statement, kind):
    reproduced = np.array(rates_by_replicates(statement, kind, (3, 6, 12, 24, 48), 100))
    if np.isnan(reproduced).all():
        assert (statement, kind) == ("equality", "two states")
        return
    # What hundred trials may scatter.
    assert (np.diff(reproduced) > -0.1).all() and reproduced[-1] > 0.9
