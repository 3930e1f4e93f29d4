"""What a point costs before it is run: particles, steps, time on one core."""

from dataclasses import dataclass

from sim.parameters import BeltParameters, Parameters

CHUTE_RATE = 45.0e6
CHUTE_RATE_DEPTH = 5.0
CHUTE_RATE_EXPONENT = -0.55
BELT_RATE = 55.0e6
BELT_SETTLING = 0.7
PROCESS_TIME = 0.9
PROCESS_MEMORY = 300.0
PARTICLE_MEMORY = 4e-3
"""Rates, times and memory on one core of a present-day server.

``CHUTE_RATE`` particle-steps per second at depth ``CHUTE_RATE_DEPTH``, falling with depth by the
power ``CHUTE_RATE_EXPONENT`` (more contacts per particle) and constant above it;
``BELT_RATE`` particle-steps per second; ``BELT_SETTLING`` seconds of simulated time until a
released bed is at rest; ``PROCESS_TIME`` seconds to start a process and write its file;
``PROCESS_MEMORY`` and ``PARTICLE_MEMORY`` in MB, with room to spare.
"""


@dataclass(frozen=True)
class Estimate:
    """Size and cost of a point: ``steps`` is over all replicates, ``core_seconds`` on one core.

    ``threads`` of each of its runs and the memory (MB) to reserve for it.
    """

    particles: int
    steps: int
    core_seconds: float
    threads: int
    memory: int


def estimate(parameters: Parameters) -> Estimate:
    """Estimate what all replicates of a point take together."""
    steps = parameters.steps
    if isinstance(parameters, BeltParameters):
        rate, threads = BELT_RATE, 1
        steps += round(BELT_SETTLING / parameters.settling_step)
        if parameters.prior_frequency > 0.0:
            steps += parameters.prior_cycles * parameters.steps_per_cycle
    else:
        depth = max(CHUTE_RATE_DEPTH, parameters.depth)
        threads = parameters.threads
        rate = CHUTE_RATE * (depth / CHUTE_RATE_DEPTH) ** CHUTE_RATE_EXPONENT
    steps *= parameters.replicates
    return Estimate(
        particles=parameters.particles,
        steps=steps,
        core_seconds=PROCESS_TIME + steps * parameters.particles / rate,
        threads=threads,
        memory=round(PROCESS_MEMORY + PARTICLE_MEMORY * parameters.particles),
    )
