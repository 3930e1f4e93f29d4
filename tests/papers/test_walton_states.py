"""Flows that judges compare have one age; states are told by majorities and lifetimes."""

import numpy as np
import pytest

from sim.claims.checks import above
from sim.claims.evidence import Evidence
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, Untestable
from sim.measures.layers import spell_statistics
from sim.papers.walton.judges.chute import (
    flows_of_one_age,
    majority_if_mixed,
    reason_incomparable,
    state_lifetime,
)
from tests.made.chute_flows import PACKING, SIZE, flow, kinked_profile
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


def deep(shares, riding):
    """Return a flow with crystalline shares per replicate; the first ``riding`` have a plug."""
    velocity = np.array(
        [kinked_profile(2 if k < riding else 20, 20, replicates=1)[0] for k in range(8)]
    )
    profiles = {
        "velocity_profile": velocity,
        "packing_profile": lambda z: PACKING * (z < 20 * SIZE / 0.9),
    }
    point = flow(15, {"crystalline_share": np.array(shares)}, profiles, depth=20, replicates=8)
    return Evidence(made_results(point), "published").at("chute", depth=20)


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        ([0.9, 0.8, 0.9, 0.8, 0.9, 0.8, 0.9, 0.4], REPRODUCED),
        ([0.9, 0.8, 0.9, 0.8, 0.3, 0.3, 0.3, 0.3], INCONCLUSIVE),
        ([0.9, 0.3, 0.4, 0.3, 0.3, 0.3, 0.3, 0.3], NOT_REPRODUCED),
    ],
)
def test_of_runs_in_different_states_most_must_hold(shares, verdict):
    place = deep(shares, riding=4)
    check = above("share", place.value("crystalline_share"), 0.5, [place])
    majority = majority_if_mixed(check, place, place.values("crystalline_share"))
    assert majority.what == "share of runs, 4 of 8 with a plug, that hold: share"
    assert majority.value == np.mean(np.array(shares) > 0.5) and majority.verdict == verdict


def test_the_lifetime_does_not_depend_on_the_length_of_the_runs():
    """States that end at random after 500 on average, seen in windows of 200, 1,000 and 5,000."""
    rng = np.random.default_rng(2)
    for window, runs in ((200, 2000), (1000, 400), (5000, 80)):
        length = np.full(window // 10, 10.0)
        time, endings = 0.0, 0.0
        for _ in range(runs):
            inside = np.cumsum(rng.random(length.size) < 10.0 / 500.0) % 2 == rng.integers(2)
            _, lived, ended = spell_statistics(inside, length)
            time, endings = time + lived, endings + ended
        # What a run shows ends in one spell fewer than it has.
        assert time / endings == pytest.approx(500, rel=0.12)


def test_the_interval_holds_the_lifetime():
    rng = np.random.default_rng(3)
    is_inside = []
    for _ in range(400):
        time = 4000.0
        lifetime = state_lifetime(time, int(rng.poisson(time / 500)))
        is_inside.append(lifetime[1] < 500 < lifetime[2])
    assert np.mean(is_inside) > 0.94


def test_a_state_that_never_ended_lasts_longer_than_a_third_of_the_time():
    assert state_lifetime(3.0, 0) == (np.inf, pytest.approx(3.0 / np.log(20)), np.inf)
