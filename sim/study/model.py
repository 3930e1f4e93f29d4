"""Model of a study: points, boundaries to be found, figures."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from sim.base.additions import Plugin
from sim.study.design import Axis
from sim.study.design_file import DesignFile
from sim.study.entries import DecideFile
from sim.study.figure_spec import FigureSpec
from sim.study.plottable import Shown
from sim.study.points import Boundary, Point
from sim.study.surrogate import MOST_ROUNDS, Question, SurrogateFile


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
