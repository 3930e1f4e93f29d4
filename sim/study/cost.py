"""Estimated cost of a point before it is run: particles, steps, time on one core."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from heapq import heappop, heappush
from math import ceil

from sim.parameters import Parameters

#: Seconds to start a process and write its file.
PROCESS_TIME = 0.9

#: Work of a time step beside that of its particles, in particles.
STEP_WORK = 15

#: Memory (MB) of a process, and of each of its particles, with a margin.
PROCESS_MEMORY = 300.0
PARTICLE_MEMORY = 4e-3

#: Space that a trajectory takes, per MB of its frames: in memory while a run file is written, and
#: on the disk, where the run file and the saved states beside it both hold the frames.
TRAJECTORY_MEMORY = 3.5
TRAJECTORY_DISK = 2.0


@dataclass(frozen=True)
class Estimate:
    """Size and cost of a point.

    Attributes
    ----------
    particles : int
        Number of particles.
    steps : int
        Time steps of all replicates together.
    core_seconds : float
        Time on one core (s).
    threads : int
        Threads of each of its runs.
    memory : int
        Memory (MB) to reserve.
    frames : int
        Maximum number of frames of its trajectories.
    trajectory : float
        Maximum disk space (MB) of its trajectories.
    """

    particles: int
    steps: int
    core_seconds: float
    threads: int
    memory: int
    frames: int
    trajectory: float


def estimate(parameters: Parameters) -> Estimate:
    """Estimate the cost of all replicates of a point together, glued particles included.

    The first run of its loops on a machine compiles them, which takes a minute that is not in it.
    """
    particles = parameters.effective_particles + STEP_WORK
    steps = parameters.replicates * (parameters.settling_steps + parameters.steps)
    megabytes = 1e-6 * parameters.trajectory_bytes
    return Estimate(
        particles=parameters.particles,
        steps=steps,
        core_seconds=PROCESS_TIME + steps * particles / parameters.rate,
        threads=parameters.cores,
        memory=round(PROCESS_MEMORY + PARTICLE_MEMORY * particles + TRAJECTORY_MEMORY * megabytes),
        frames=parameters.trajectory_frames,
        trajectory=TRAJECTORY_DISK * megabytes,
    )


#: Limits on the computing time (s) of a batch. Between them, there is one batch for every core.
#: A point that takes more than half of the maximum has a process of its own.
MIN_BATCH_SECONDS, MAX_BATCH_SECONDS = 3.0, 60.0

#: Maximum number of points in a batch: for each point, Snakemake looks through the whole batch.
MAX_BATCH_POINTS = 50


def plan_batches(points: Mapping[str, Parameters], cores: float | None) -> dict[str, list[str]]:
    """Return a map from the name of each batch of short points to their ids, longest first.

    Parameters
    ----------
    points : mapping
        Points to be run, by id. A point is in no batch if it takes long, needs several threads or
        would be the only one of its batch.
    cores : float, optional
        Number of cores that they run on. If it is unknown, as on a cluster, batches are as long as
        allowed: there, each batch is a job, which takes seconds to start.
    """
    seconds = {}
    for name, point in points.items():
        cost = estimate(point)
        if cost.threads == 1 and cost.core_seconds - PROCESS_TIME <= MAX_BATCH_SECONDS / 2:
            seconds[name] = cost.core_seconds - PROCESS_TIME
    total = sum(seconds.values())
    batch_seconds = (
        min(max(total / cores, MIN_BATCH_SECONDS), MAX_BATCH_SECONDS)
        if cores
        else MAX_BATCH_SECONDS
    )
    number = max(ceil(total / batch_seconds), ceil(len(seconds) / MAX_BATCH_POINTS))
    batches: list[list[str]] = [[] for _ in range(number)]
    open_batches = [(0.0, index) for index in range(number)]
    # Longest points first, each to the shortest batch: all batches end at about the same time.
    for name in sorted(seconds, key=lambda name: (-seconds[name], name)):
        seconds_taken, index = heappop(open_batches)
        batches[index].append(name)
        if len(batches[index]) < MAX_BATCH_POINTS:
            heappush(open_batches, (seconds_taken + seconds[name], index))
    return {_batch_name(members): members for members in batches if len(members) > 1}


def _batch_name(members: list[str]) -> str:
    return f"batch_{hashlib.sha256(' '.join(members).encode()).hexdigest()[:8]}"
