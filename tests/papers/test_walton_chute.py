"""Flows that judges compare begin their averages at one age, if they can."""

import pytest

from sim.claims.evidence import Evidence
from sim.claims.verdict import Untestable
from sim.papers.walton.judges.chute import flows_of_one_age, reason_incomparable
from tests.made.chute_flows import flow
from tests.made.results import made_results

WHERES = [{"depth": 10, "cell": 5}, {"depth": 20, "cell": 5}]


def chosen(*windows):
    """Return the flows of one age of windows: depth, age and number of replicates of each."""
    points = [
        flow(15, depth=depth, cell=5, transient=start, replicates=replicates)
        for depth, start, replicates in windows
    ]
    return flows_of_one_age(Evidence(made_results(*points), "published"), WHERES)


@pytest.mark.parametrize(
    ("windows", "ages"),
    [
        # Each flow has more replicates at an age that the other has not.
        ([(10, 300, 3), (10, 600, 9), (20, 300, 3), (20, 900, 9)], (300, 300)),
        # The flow with the fewest replicates counts, however many the other has.
        ([(10, 300, 9), (10, 600, 4), (20, 300, 3), (20, 600, 4)], (600, 600)),
        ([(10, 300, 5), (10, 600, 4), (20, 300, 5), (20, 600, 9)], (300, 300)),
        # Of as many replicates the oldest.
        ([(10, 300, 4), (10, 2000, 4), (20, 300, 4), (20, 2000, 4)], (2000, 2000)),
        # Single runs are of no age.
        ([(10, 300, 9), (10, 600, 1), (20, 600, 1), (20, 900, 9)], (300, 900)),
        # Without a common age, most replicates of each.
        ([(10, 300, 3), (10, 600, 9), (20, 900, 3), (20, 2000, 9)], (600, 2000)),
        ([(10, 300, 9), (20, 300, 1)], (300, 300)),
    ],
)
def test_the_age_is_that_with_most_replicates_then_the_oldest(windows, ages):
    flows = chosen(*windows)
    assert [(place["depth"], place["transient"]) for place in flows] == list(
        zip((10, 20), ages, strict=True)
    )
    assert (reason_incomparable(flows) == "") == (ages[0] == ages[1])


def test_without_a_flow_there_is_no_age():
    with pytest.raises(Untestable, match="depth 20, cell 5"):
        chosen((10, 300, 5))
