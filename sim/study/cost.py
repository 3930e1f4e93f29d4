"""Estimated cost of a point before it is run: particles, steps, time on one core."""

from dataclasses import dataclass

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
