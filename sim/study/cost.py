"""What a point costs before it is run: particles, steps, time on one core."""

from dataclasses import dataclass

from sim.parameters import Parameters

#: Seconds to start a process and write its file.
PROCESS_TIME = 0.9

#: MB of a process and of each of its particles, with room to spare.
PROCESS_MEMORY = 300.0
PARTICLE_MEMORY = 4e-3

#: MB that frames of a trajectory take while a run is written, for each that they have, and on the
#: disk: in the run file and in the states beside it.
TRAJECTORY_MEMORY = 3.5
TRAJECTORY_DISK = 2.0


@dataclass(frozen=True)
class Estimate:
    """Size and cost of a point: ``steps`` is over all replicates, ``core_seconds`` on one core.

    ``threads`` of each of its runs, the memory (MB) to reserve for it, and what its trajectories
    take on the disk (MB), at most.
    """

    particles: int
    steps: int
    core_seconds: float
    threads: int
    memory: int
    trajectory: float


def estimate(parameters: Parameters) -> Estimate:
    """Estimate what all replicates of a point take together, glued particles included."""
    every = parameters.effective_particles
    steps = parameters.replicates * (parameters.settling_steps + parameters.steps)
    frames = 1e-6 * parameters.trajectory_bytes
    return Estimate(
        particles=parameters.particles,
        steps=steps,
        core_seconds=PROCESS_TIME + steps * every / parameters.rate,
        threads=parameters.cores,
        memory=round(PROCESS_MEMORY + PARTICLE_MEMORY * every + TRAJECTORY_MEMORY * frames),
        trajectory=TRAJECTORY_DISK * frames,
    )
