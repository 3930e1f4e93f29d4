"""Model of a study: points, boundaries to be found, figures."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from sim.base.additions import Plugin
from sim.study.design import Axis
from sim.study.design_file import DesignFile
from sim.study.entries import DecideFile
from sim.study.figure_spec import FigureSpec
from sim.study.plot_kinds import Shown
from sim.study.points import Boundary, Point
from sim.study.surrogate import MOST_ROUNDS, Question, SurrogateFile


class Need(NamedTuple):
    """What is read of a point besides scalars: a level of particles, profiles, and series."""

    particles: Shown
    profiles: bool
    series: bool = False


@dataclass(frozen=True)
class Study:
    """A validated study.

    Attributes
    ----------
    name, title : str
        Name of the study and of its folder of results; one line for the report.
    files : tuple of Path
        The study file, then those of its parts.
    points : dict
        Points by id, in the order of the file; equal points of several series appear once. They
        include the points of the first round of the boundaries.
    series : dict
        Ids of the points of each series (or boundary), in order.
    boundaries : tuple of Boundary
        Boundaries to be found.
    axes : dict
        The parameters that the points of each series vary, by grid, cases or design, in order.
    designs : dict
        The designs of the series that have one.
    entries : dict
        Figures that its points feed, by name: entries of the catalogue, then its own plots.
    readings : mapping
        Readings of the paper under which every series is run, by system. Each reading maps the
        parameters that differ from their defaults to values.
    decide : DecideFile or None
        What more replicates are to decide. The parameters of the points include those added so far.
    plugins : tuple of Plugin
        The plug-ins that it and its parts name.
    data : tuple of Path
        CSV files of data from elsewhere that it names.
    questions : tuple of Question
        What is answered from the dataset: surrogates, sensitivities, calibrations.
    """

    name: str
    title: str
    files: tuple[Path, ...]
    points: dict[str, Point]
    series: dict[str, tuple[str, ...]]
    boundaries: tuple[Boundary, ...]
    axes: Mapping[str, tuple[Axis, ...]] = field(default_factory=dict)
    designs: Mapping[str, DesignFile] = field(default_factory=dict)
    entries: dict[str, FigureSpec] = field(default_factory=dict)
    readings: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
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
        return max((self.entries[name].particles for name in figures), default=Shown.NOTHING)

    def need(self, point: str) -> Need:
        """Return what the dataset must store of a point besides its scalars.

        ``series`` is whether a plot reads time series from its run file.
        """
        if point not in self.points:
            return self._later_need
        one = self.points[point]
        shown = max(self._later_need.particles, self.particles_shown(one.figures))
        has_series = any(
            spec.is_fed_by(one.parameters.system, one.series) for spec in self._time_series
        )
        return Need(shown, one.profiles, has_series)

    @cached_property
    def _later_need(self) -> Need:
        """What a point of a later round may need: the figures that it feeds are not known yet."""
        lists = [one.figures for one in self.boundaries] + [one.figures for one in self.surrogates]
        names = {boundary.name for boundary in self.boundaries}
        names |= {one.series for one in self.surrogates}
        has_series = any(not names.isdisjoint(spec.series or ()) for spec in self._time_series)
        return Need(self.particles_shown(chain(*lists)), True, has_series)

    @cached_property
    def _time_series(self) -> list[FigureSpec]:
        """Plots of that kind, and of a plug-in's kind based on it."""
        return [spec for spec in self.plots.values() if spec.keys.from_runs]

    @property
    def omission_notes(self) -> list[str]:
        """A sentence for each figure that omits points of its series: how many, and why.

        Pictures of a single point get none, since they omit all other points by definition.
        """
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
