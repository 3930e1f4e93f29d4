"""Short points share a process; long ones, and those of several threads, have their own."""

from math import ceil

import numpy as np
import pytest

from sim.parameters import BeltParameters, ChuteParameters, point_id
from sim.study.batches import MAX_BATCH_POINTS, MAX_BATCH_SECONDS, MIN_BATCH_SECONDS, plan_batches
from sim.study.cost import PROCESS_TIME, estimate

SHORT = [BeltParameters(frequency=frequency) for frequency in range(10, 60)]
LONG = ChuteParameters(depth=20, cell=10)
THREADED = ChuteParameters(depth=1, threads=2)


def points_by_id(points):
    return {point_id(point): point for point in points}


def seconds(point):
    return estimate(point).core_seconds - PROCESS_TIME


@pytest.mark.parametrize("cores", [1, 2, 1000])
def test_every_short_point_is_in_one_batch_of_the_right_length(cores):
    points = points_by_id([*SHORT, LONG, THREADED])
    batches = plan_batches(points, cores)
    members = [name for batch in batches.values() for name in batch]
    assert sorted(members) == sorted(points_by_id(SHORT))
    longest, total = max(map(seconds, SHORT)), sum(map(seconds, SHORT))
    share = min(max(total / cores, MIN_BATCH_SECONDS), MAX_BATCH_SECONDS)
    assert len(batches) == max(ceil(total / share), ceil(len(SHORT) / MAX_BATCH_POINTS))
    for batch in batches.values():
        batch_time = sum(seconds(points[name]) for name in batch)
        assert abs(batch_time - total / len(batches)) <= longest


def test_points_that_take_equally_long_are_dealt_out():
    points = points_by_id(SHORT)
    first, second = plan_batches(points, 2).values()
    frequencies = [np.mean([points[name].frequency for name in batch]) for batch in (first, second)]
    assert abs(np.diff(frequencies)) < 2


def test_the_longest_come_first():
    points = points_by_id(SHORT)
    for batch in plan_batches(points, 2).values():
        times = [seconds(points[name]) for name in batch]
        assert times == sorted(times, reverse=True)


def test_a_point_alone_is_in_no_batch():
    assert plan_batches(points_by_id(SHORT[:1]), 1) == {}
    assert plan_batches({}, 1) == {}


def test_names_tell_their_points():
    first, second = (
        plan_batches(points_by_id(SHORT[:2]), 1),
        plan_batches(points_by_id(SHORT[:3]), 1),
    )
    assert set(first).isdisjoint(second)
    assert list(first) == list(plan_batches(points_by_id(SHORT[:2]), 1))


def test_a_batch_of_very_short_points_is_no_crowd():
    tiny = [BeltParameters(beads=5, width=5, transient=1, average=1, seed=n) for n in range(120)]
    assert [len(batch) for batch in plan_batches(points_by_id(tiny), 1000).values()] == [40, 40, 40]
