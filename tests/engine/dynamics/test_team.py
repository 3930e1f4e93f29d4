"""Threads that advance one flow together: the gate, and the flow of a single thread."""

import threading

import numpy as np
import pytest

from sim.engine.contact.friction import make_memory
from sim.engine.dynamics.neighbors import empty_pair_list
from sim.engine.dynamics.team import Team
from sim.engine.systems import build
from tests.engine_motion.helpers import meet
from tests.engine_motion.points import chute_point


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_behind_a_gate_all_threads_see_what_the_others_did_before_it(threads):
    team, count = Team(threads), np.zeros(threads, np.int64)
    missed = np.full(threads, -1)

    def task(rank: int) -> int:
        missed[rank] = meet(team.gate, 1000, rank, count)
        return 0

    for _ in range(3):
        count[:] = 0
        team.run(task)
        assert not missed.any()
        assert (count == 1000).all()


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


@pytest.mark.parametrize("broken", [0, 1, 2])
def test_nobody_waits_for_a_thread_that_has_failed(broken):
    team, count = Team(3), np.zeros(3, np.int64)

    def task(rank: int) -> int:
        if rank == broken:
            raise KeyboardInterrupt
        return meet(team.gate, 1, rank, count)

    with pytest.raises(KeyboardInterrupt):
        team.run(task)


DENSE = {"cell": 6, "depth": 5, "initial_packing": 0.35, "initial_agitation": 0.5}


def flow(threads: int, samples: int, **values):
    """Time series and last state of a dense flow; contacts among all particles from the start."""
    system = build(chute_point(**DENSE | {"threads": threads} | values), 0)
    return [system.advance() for _ in range(samples)], system.snapshot(), system


def test_threads_share_the_particles_out_by_their_pairs():
    _, _, system = flow(3, 1, sample_interval=0.1)
    border, start = system.flow.sharing.border, system.pairs.start
    assert border[0] == 0 and border[-1] == system.parameters.particles
    shares = np.diff(start[border])
    assert shares.sum() == start[-1]
    assert shares.max() - shares.min() < 0.1 * start[-1]


@pytest.mark.parametrize("settings", [{"cell": 5, "depth": 0.04}, {"cell": 3, "depth": 0.33}])
def test_more_threads_than_particles_are_no_harm(settings):
    series, state, system = flow(4, 2, sample_interval=0.5, **settings)
    expected, single, _ = flow(1, 2, sample_interval=0.5, **settings)
    assert system.parameters.particles <= 3
    assert state["position"] == pytest.approx(single["position"], rel=1e-9)
    assert series[-1]["mean_velocity"] == pytest.approx(expected[-1]["mean_velocity"], rel=1e-9)


def test_a_list_that_grows_under_threads_loses_nothing():
    """The flow settles from its dilute start: its pairs double, and the list with them."""
    system = build(chute_point(**DENSE, threads=2), 0)
    capacity = system.pairs.second.size
    system.pairs = empty_pair_list(
        system.spheres.radius, system.box, system.pairs.skin, per_particle=0
    )
    system.memory = make_memory(system.laws[0], len(system.pairs.touching))
    small = system.pairs.second.size
    series = [system.advance() for _ in range(2)]
    assert system.pairs.second.size > small
    roomy = build(chute_point(**DENSE, threads=2), 0)
    assert series == [roomy.advance() for _ in range(2)]
    assert roomy.pairs.second.size == capacity
