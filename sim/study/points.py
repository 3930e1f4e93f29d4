"""Points of a study: what one is, what it costs, and which come next along a boundary."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from heapq import heappop, heappush
from math import ceil
from typing import Any

from sim.parameters import Parameters, canonical_number
from sim.parameters.common import STEP_WORK


@dataclass(frozen=True)
class Point:
    """One point of a study, which may belong to several series and figures.

    ``left_out`` holds the figures that its series feed but that do not show it. ``looks`` is how
    often claims on it are judged with the option of buying more runs. ``profiles`` is whether the
    dataset has its profiles.
    """

    id: str
    parameters: Parameters
    series: tuple[str, ...]
    figures: tuple[str, ...]
    left_out: tuple[str, ...] = ()
    looks: int = 0
    profiles: bool = True


#: Seconds to start a run in a process that batches share, and to write its file.
FILE_TIME = 0.06

#: Memory (MB) of a process, and of each of its particles, with a margin.
PROCESS_MEMORY, PARTICLE_MEMORY = 300.0, 4e-3

#: Space that a trajectory takes, per MB of its frames: in memory while a run file is written, and
#: on the disk, where the run file and the saved states beside it both hold the frames.
TRAJECTORY_MEMORY, TRAJECTORY_DISK = 3.5, 2.0


@dataclass(frozen=True)
class Estimate:
    """Size and cost of a point.

    ``steps`` are those of all replicates together, ``core_seconds`` the time on one core (s),
    ``threads`` those of each run, ``memory`` (MB) is what to reserve, ``frames`` and ``trajectory``
    are the most frames of its trajectories and their space on the disk (MB).
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
        core_seconds=FILE_TIME + steps * particles / parameters.rate,
        threads=parameters.cores,
        memory=round(PROCESS_MEMORY + PARTICLE_MEMORY * particles + TRAJECTORY_MEMORY * megabytes),
        frames=parameters.trajectory_frames,
        trajectory=TRAJECTORY_DISK * megabytes,
    )


#: Limits on the computing time (s) of a batch. Between them, there is one batch for every core.
#: A point that takes more than half of the maximum has a process of its own. And maximum number of
#: points in a batch: for each point, Snakemake looks through the whole batch.
MIN_BATCH_SECONDS, MAX_BATCH_SECONDS, MAX_BATCH_POINTS = 3.0, 60.0, 50


def plan_batches(points: Mapping[str, Parameters], cores: float | None) -> dict[str, list[str]]:
    """Return a map from the name of each batch of short points to their ids, longest first.

    A point is in no batch if it takes long, needs several threads or would be the only one of its
    batch. If the number of ``cores`` is unknown, as on a cluster, batches are as long as allowed:
    there, each batch is a job, which takes seconds to start.
    """
    seconds = {}
    for name, point in points.items():
        cost = estimate(point)
        if cost.threads == 1 and cost.core_seconds <= MAX_BATCH_SECONDS / 2:
            seconds[name] = cost.core_seconds
    total = sum(seconds.values())
    share = max(total / cores, MIN_BATCH_SECONDS) if cores else MAX_BATCH_SECONDS
    batch_seconds = min(share, MAX_BATCH_SECONDS)
    number = max(ceil(total / batch_seconds), ceil(len(seconds) / MAX_BATCH_POINTS))
    batches: list[list[str]] = [[] for _ in range(number)]
    open_batches = [(0.0, index) for index in range(number)]
    # Longest points first, each to the shortest batch: all batches end at about the same time.
    for name in sorted(seconds, key=lambda name: (-seconds[name], name)):
        seconds_taken, index = heappop(open_batches)
        batches[index].append(name)
        if len(batches[index]) < MAX_BATCH_POINTS:
            heappush(open_batches, (seconds_taken + seconds[name], index))
    shared = [members for members in batches if len(members) > 1]
    hashes = (hashlib.sha256(" ".join(members).encode()).hexdigest() for members in shared)
    return {f"batch_{one[:8]}": members for one, members in zip(hashes, shared, strict=True)}


@dataclass(frozen=True)
class Boundary:
    """One boundary to be found, with all parameters but one fixed.

    ``name`` is that of its entry in the study file, whose boundaries differ in the values of their
    ``grid``. ``of`` is what changes, ``along`` the parameter along which it is searched, from
    ``low`` to ``high``, to within ``tolerance``. It feeds ``figures``; ``parameters_at`` is a
    function: value of ``along`` → parameters of the point there.
    """

    name: str
    of: str
    along: str
    low: float
    high: float
    tolerance: float
    grid: dict[str, Any]
    figures: tuple[str, ...]
    parameters_at: Callable[[float], Parameters]

    @property
    def rounds(self) -> int:
        """Number of rounds of refinement after the first."""
        return further_rounds(self.low, self.high, self.tolerance)


#: Number of parts into which a range, and later each gap that may hold the boundary, is divided;
#: maximum number of further rounds, as a tolerance that needs more is refused; and relative slack
#: of comparisons with the tolerance: steps of 0.1 need not sum to 0.4.
PARTS, MAX_ROUNDS, _SLACK = 4, 8, 1e-9

#: Map from values of a parameter to the name of their side, ``None`` where it is undecided.
Sides = Mapping[float, str | None]


@dataclass(frozen=True)
class BoundaryEstimate:
    """Estimate of a boundary.

    Its ``verdict`` is ``found``: known within the tolerance; ``wide``: known less exactly, as the
    values in between are undecided or contradict each other; ``none``: all decided values, both
    ends of the range among them, are on one side; ``several``: both ends are on the same side,
    values in between on the other; ``open``: at most one side occurs, and an end is undecided.
    ``below`` and ``above`` are the sides of the lowest and the highest decided value, empty without
    one. ``low`` and ``high`` contain the boundary, if it is ``found`` or ``wide``.
    """

    verdict: str
    below: str
    above: str
    low: float | None = None
    high: float | None = None


def further_rounds(low: float, high: float, tolerance: float) -> int:
    """Return the number of rounds after the first that bring every gap down to the tolerance.

    >>> further_rounds(10, 20, 0.25)
    2
    """
    rounds, gap = 0, (high - low) / PARTS
    while gap > tolerance * (1 + _SLACK) and rounds <= MAX_ROUNDS:
        rounds, gap = rounds + 1, gap / PARTS
    return rounds


def divide_range(low: float, high: float) -> list[float]:
    """Return the ends of a range and the values that divide it into `PARTS`, in canonical form."""
    step = (high - low) / PARTS
    return [canonical_number(low + step * part) for part in range(PARTS)] + [high]


def locate_boundary(sides: Sides, tolerance: float) -> BoundaryEstimate:
    """Return the estimate of a boundary from the sides of some values.

    All decided values below ``low`` are on the side of the low end, all above ``high`` on the side
    of the high end.
    """
    decided = [(value, side) for value, side in sorted(sides.items()) if side is not None]
    if not decided:
        return BoundaryEstimate("open", "", "")
    below, above = decided[0][1], decided[-1][1]
    if below == above:
        if any(side != below for _, side in decided):
            return BoundaryEstimate("several", below, above)
        has_decided_ends = sides[min(sides)] is not None and sides[max(sides)] is not None
        return BoundaryEstimate("none" if has_decided_ends else "open", below, above)
    first = next(index for index, (_, side) in enumerate(decided) if side != below)
    last = max(index for index, (_, side) in enumerate(decided) if side != above)
    low, high = decided[first - 1][0], decided[last + 1][0]
    verdict = "found" if high - low <= tolerance * (1 + _SLACK) else "wide"
    return BoundaryEstimate(verdict, below, above, low, high)


def next_values(sides: Sides, tolerance: float) -> list[float]:
    """Return the values to compute next, or none if no value would help.

    The gap between ``low`` and ``high`` of `locate_boundary` is divided. Values in between are
    undecided or contradict each other, and further ones among them would do the same: then the gaps
    next to ``low`` and ``high`` are divided, which narrows the undecided zone.
    """
    boundary = locate_boundary(sides, tolerance)
    low, high = boundary.low, boundary.high
    if low is None or high is None:
        return []
    inside = sorted(value for value in sides if low < value < high)
    gaps = [(low, inside[0]), (inside[-1], high)] if inside else [(low, high)]
    wide = [(low, high) for low, high in gaps if high - low > tolerance * (1 + _SLACK)]
    return [value for low, high in wide for value in divide_range(low, high)[1:-1]]
