"""Model of a study: points and their cost, boundaries and which values come next, figures."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from sim.base.additions import Plugin
from sim.parameters import Parameters, canonical_number
from sim.parameters.common import STEP_WORK
from sim.study.design import Axis
from sim.study.design_file import DesignFile
from sim.study.entries import DecideFile
from sim.study.figure_spec import FigureSpec
from sim.study.plottable import Shown
from sim.study.surrogate import MOST_ROUNDS, Question, SurrogateFile


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


class Need(NamedTuple):
    """What is read of a point besides scalars: particles, profiles, series of its run."""

    particles: Shown
    profiles: bool
    series: bool = False


@dataclass(frozen=True)
class Study:
    """A validated study.

    ``files`` are the study file, then those of its parts. ``points`` are by id, in the order of the
    file; equal points of several series appear once, and those of the first round of the boundaries
    are among them. Of each series (or boundary), ``series`` has the ids, ``axes`` the parameters
    that its points vary, by grid, cases or design, and ``designs`` the design, if it has one.
    ``entries`` are the figures that the points feed, by name: those of papers, then its own plots.
    ``readings`` are those of the papers under which every series is run, by system, each as values
    that differ from the defaults. ``paper`` is the one whose values stand where the study gives
    none, empty for the usual defaults, and ``units`` are ``si`` or ``natural``. ``decide`` is what
    more replicates are to decide; the parameters of the points include those added so far.
    ``plugins`` and ``data`` (CSV files) are what it and its parts name, and ``questions`` what is
    answered from the dataset.
    """

    name: str
    title: str
    files: tuple[Path, ...]
    points: dict[str, Point]
    series: dict[str, tuple[str, ...]]
    boundaries: tuple[Boundary, ...] = ()
    axes: Mapping[str, tuple[Axis, ...]] = field(default_factory=dict)
    designs: Mapping[str, DesignFile] = field(default_factory=dict)
    entries: dict[str, FigureSpec] = field(default_factory=dict)
    readings: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    paper: str = ""
    units: str = "si"
    decide: DecideFile | None = None
    plugins: tuple[Plugin, ...] = ()
    data: tuple[Path, ...] = ()
    questions: tuple[Question, ...] = ()

    @cached_property
    def figures(self) -> dict[str, tuple[str, ...]]:
        """Ids of the points of each figure and plot, in order."""
        return {
            name: tuple(
                point.id
                for point in self.points.values()
                if name in point.figures or spec.is_fed_by(point.parameters.system, point.series)
            )
            for name, spec in self.entries.items()
        }

    @property
    def plots(self) -> dict[str, FigureSpec]:
        """Entries of the study's own plots, by name."""
        return {name: spec for name, spec in self.entries.items() if not spec.paper}

    @property
    def sources(self) -> tuple[Path, ...]:
        """The study file, the files of its parts, and plug-ins and data beside them."""
        plugins = tuple(file for plugin in self.plugins for file in plugin.files)
        return self.files + plugins + self.data

    @property
    def path(self) -> Path:
        """The study file."""
        return self.files[0]

    @property
    def surrogates(self) -> tuple[SurrogateFile, ...]:
        """Its surrogates."""
        return tuple(one for one in self.questions if isinstance(one, SurrogateFile))

    @property
    def rounds(self) -> int:
        """Maximum number of rounds after the first; they end with one that adds no point."""
        if any(one.has_rounds for one in self.surrogates):
            return MOST_ROUNDS
        return max((boundary.rounds for boundary in self.boundaries), default=0)

    def particles_shown(self, figures: Iterable[str]) -> Shown:
        """Return how much of their points' particles some figures show."""
        shown = (self.entries[name].keys.particles for name in figures)
        return max(shown, default=Shown.NOTHING)

    def need(self, point: str) -> Need:
        """Return what the dataset must store of a point besides its scalars."""
        if point not in self.points:
            return self._later_need
        one = self.points[point]
        shown = max(self._later_need.particles, self.particles_shown(one.figures))
        system, plots = one.parameters.system, self._time_series
        has_series = any(spec.is_fed_by(system, one.series) for spec in plots)
        return Need(shown, one.profiles, has_series)

    @cached_property
    def _later_need(self) -> Need:
        """What a point of a later round may need: the figures that it feeds are not known yet."""
        growing: tuple[Any, ...] = (*self.boundaries, *self.surrogates)
        names = {one.series if isinstance(one, SurrogateFile) else one.name for one in growing}
        has_series = any(not names.isdisjoint(spec.series or ()) for spec in self._time_series)
        shown = self.particles_shown(name for one in growing for name in one.figures)
        return Need(shown, True, has_series)

    @cached_property
    def _time_series(self) -> list[FigureSpec]:
        """Plots of that kind, and of a plug-in's kind based on it."""
        return [spec for spec in self.plots.values() if spec.keys.from_runs]

    @property
    def omission_notes(self) -> list[str]:
        """A sentence for each figure that omits points, but for pictures of a single one."""
        sentences = []
        for name, members in self.figures.items():
            spec = self.entries[name]
            omitted = [one.parameters for one in self.points.values() if name in one.left_out]
            if omitted and spec.axes:
                total = len(omitted) + len(members)
                points = f"{len(omitted):,} of {total:,} point" + "s" * (total > 1)
                values = "; ".join(
                    f"{key} {values}"
                    for key, values in spec.taken.items()
                    if any(not spec.takes(key, parameters) for parameters in omitted)
                )
                sentences.append(f"{name} leaves out {points}: it takes {values}")
        return sentences
