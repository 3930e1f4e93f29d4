"""Threads that advance one flow together: the gate, and who returns what."""

import threading

import numpy as np
import pytest

from sim.engine.dynamics.team import Team, make_gate
from tests.engine_motion.helpers import meet


@pytest.mark.parametrize("threads", [1, 2, 3, 5])
def test_behind_a_gate_all_threads_see_what_the_others_did_before_it(threads):
    team, count = Team(threads), np.zeros(threads, np.int64)
    missed = np.full(threads, -1)

    def task(rank: int) -> int:
        missed[rank] = meet(team.gate, 1000, rank, count)
        return 0

    team.run(task)
    assert not missed.any()
    assert (count == 1000).all()


def test_a_gate_serves_again_and_again():
    team, count = Team(3), np.zeros(3, np.int64)
    for _ in range(20):
        count[:] = 0
        assert team.run(lambda rank: meet(team.gate, 50, rank, count)) == 0


def test_a_team_returns_what_its_first_thread_returns_after_the_others_have_ended():
    team, ended = Team(4), []

    def task(rank: int) -> int:
        if rank:
            release.wait()
            ended.append(rank)
        else:
            release.set()
        return 10 + rank

    release = threading.Event()
    assert team.run(task) == 10
    assert sorted(ended) == [1, 2, 3]


def test_the_gate_of_a_single_thread_is_open():
    assert meet(make_gate(1), 1000, 0, np.zeros(1, np.int64)) == 0


@pytest.mark.parametrize("broken", [0, 1, 2])
def test_nobody_waits_for_a_thread_that_has_failed(broken):
    team, count = Team(3), np.zeros(3, np.int64)

    def task(rank: int) -> int:
        if rank == broken:
            raise KeyboardInterrupt
        return meet(team.gate, 1, rank, count)

    with pytest.raises(KeyboardInterrupt):
        team.run(task)
