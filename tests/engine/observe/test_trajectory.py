"""Frames of a trajectory: when they are taken, how they are kept, and that they change nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

import sim
from sim.engine.observe.recorder import Trajectory

BELT = {"system": "belt", "beads": 20, "width": 5}
CHUTE = {"system": "chute", "depth": 2, "cell": 5}
SHORT = {"transient": 2, "average": 3, "replicates": 2, "progress": False}


def still(samples: int) -> SimpleNamespace:
    """A system whose only particle is where the number of its samples says."""
    place = np.full((1, 2), float(samples))
    return SimpleNamespace(snapshot=lambda: {"position": place, "radius": np.ones(1)})


def trajectory_of(samples: int, until: int) -> Trajectory:
    """A trajectory of a system that has gone from frame to frame."""
    trajectory, done = Trajectory(samples), 0
    while done < until:
        done = min([until, *trajectory.next_frame(done)])
        trajectory.take(still(done), done)
    return trajectory


def test_frames_are_taken_at_multiples_of_their_distance():
    assert Trajectory(3).next_frame(0) == Trajectory(3).next_frame(2) == [3] and Trajectory(
        3
    ).next_frame(3) == [6]
    frames = trajectory_of(3, 11).frames()
    assert list(frames) == ["trajectory_position"]
    assert frames["trajectory_position"][:, 0, 0].tolist() == [3, 6, 9]
    assert frames["trajectory_position"].dtype == np.float32


def test_without_a_distance_there_are_none():
    assert Trajectory(0).next_frame(5) == [] and trajectory_of(0, 7).frames() == {}


def test_frames_go_on_where_they_were():
    held, again = trajectory_of(2, 5).frames(), Trajectory(2)
    again.restore(held, 5)
    again.take(still(6), 6)
    assert np.array_equal(again.frames()["trajectory_position"][:, 0, 0], [2, 4, 6])
    Trajectory(2).restore({}, 1)
    for frames, samples in ((held, 6), ({}, 2), (held, 0)):
        with pytest.raises(ValueError, match="frames"):
            Trajectory(2).restore(frames, samples)


@pytest.mark.parametrize("point", [BELT, CHUTE], ids=["belt", "chute"])
def test_a_trajectory_changes_nothing_else_and_its_frames_are_the_flow(point):
    usual = sim.simulate(**point, **SHORT)
    run = sim.simulate(**point, **SHORT, trajectory=0.5)
    added = {"trajectory", "trajectory_time", "trajectory_position", "trajectory_velocity"}
    added |= {"trajectory_spin"} if point is CHUTE else set()
    assert set(run.variables) - set(usual.variables) == added
    for name in set(usual.variables) - {"wall_time", "loop_time"}:
        np.testing.assert_array_equal(run[name], usual[name], name)

    assert run.sizes["trajectory_time"] == 10 and run.trajectory_position.dtype == np.float32
    unit = float(run.time[-1]) / 5
    np.testing.assert_allclose(run.trajectory_time, np.arange(1, 11) * 0.5 * unit)
    flow = sim.Flow(**point, replicate=1).run(1.5, progress=False)
    frame = run.isel(replicate=1, trajectory_time=2)
    assert float(frame.trajectory_time) == pytest.approx(flow.time)
    assert np.array_equal(frame.trajectory_position, np.float32(flow.positions))
    assert np.array_equal(frame.trajectory_velocity, np.float32(flow.velocities))
    if point is CHUTE:
        assert np.array_equal(frame.trajectory_spin, np.float32(flow.spins))
