"""Short points share a process; long ones, and those of several threads, have their own."""

from math import ceil

import numpy as np
import pytest

from sim.parameters import BeltParameters, ChuteParameters, point_id
from sim.study.batches import CROWD, LEAST, MOST, batches
from sim.study.cost import PROCESS_TIME, estimate

SHORT = [BeltParameters(frequency=frequency) for frequency in range(10, 60)]
LONG = ChuteParameters(depth=20, cell=10)
THREADED = ChuteParameters(depth=1, threads=2)


def named(points):
    return {point_id(point): point for point in points}


def seconds(point):
    return estimate(point).core_seconds - PROCESS_TIME


@pytest.mark.parametrize("cores", [1, 2, 1000])
def test_every_short_point_is_in_one_batch_of_the_right_length(cores):
    points = named([*SHORT, LONG, THREADED])
    found = batches(points, cores)
    members = [name for batch in found.values() for name in batch]
    assert sorted(members) == sorted(named(SHORT))
    longest, total = max(map(seconds, SHORT)), sum(map(seconds, SHORT))
    share = min(max(total / cores, LEAST), MOST)
    assert len(found) == max(ceil(total / share), ceil(len(SHORT) / CROWD))
    for batch in found.values():
        taken = sum(seconds(points[name]) for name in batch)
        assert abs(taken - total / len(found)) <= longest


def test_points_that_take_equally_long_are_dealt_out():
    points = named(SHORT)
    first, second = batches(points, 2).values()
    frequencies = [np.mean([points[name].frequency for name in batch]) for batch in (first, second)]
    assert abs(np.diff(frequencies)) < 2


def test_the_longest_come_first():
    points = named(SHORT)
    for batch in batches(points, 2).values():
        times = [seconds(points[name]) for name in batch]
        assert times == sorted(times, reverse=True)


def test_a_point_alone_is_in_no_batch():
    assert batches(named(SHORT[:1]), 1) == {}
    assert batches({}, 1) == {}


def test_names_tell_their_points():
    one, other = batches(named(SHORT[:2]), 1), batches(named(SHORT[:3]), 1)
    assert set(one).isdisjoint(other)
    assert list(one) == list(batches(named(SHORT[:2]), 1))


def test_a_batch_of_very_short_points_is_no_crowd():
    tiny = [BeltParameters(beads=5, width=5, transient=1, average=1, seed=n) for n in range(120)]
    assert [len(batch) for batch in batches(named(tiny), 1000).values()] == [40, 40, 40]
