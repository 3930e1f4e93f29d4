"""Model of a study: points, boundaries to be found, figures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sim.base.additions import Plugin
from sim.parameters import Parameters
from sim.study.catalogue import FIGURES
from sim.study.entries import DecideFile
from sim.study.figure_spec import FigureSpec
from sim.study.refine import further_rounds


@dataclass(frozen=True)
class Point:
    """One point of a study, which may belong to several series and figures.

    ``left_out`` holds the figures that its series feed but that do not show it.
    """

    id: str
    parameters: Parameters
    series: tuple[str, ...]
    figures: tuple[str, ...]
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Boundary:
    """One boundary to be found, with all parameters but one fixed.

    Attributes
    ----------
    name : str
        Name of its entry in the study file; boundaries of one entry differ in ``grid``.
    of, along : str
        What changes at the boundary; the parameter along which it is searched.
    low, high, tolerance : float
        Range of that parameter, and required width of the interval that contains the boundary.
    grid : dict
        Values of the grid that belong to this boundary.
    figures : tuple of str
        Figures that it feeds.
    parameters_at : callable
        Function: value of ``along`` → parameters of the point there.
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
    series, figures : dict
        Ids of the points of each series (or boundary) and of each figure, in order.
    boundaries : tuple of Boundary
        Boundaries to be found.
    plots : mapping
        Its own plots by name, as entries like those of the catalogue; ``figures`` has them, too.
    readings : mapping
        Readings of the paper under which every series is run, by system. Each reading maps the
        parameters that differ from their defaults to values.
    decide : DecideFile or None
        What more replicates are to decide. The parameters of the points include those added so far.
    pages : bool
        Whether each point has a page, except points of later rounds.
    plugins : tuple of Plugin
        The plug-ins that it and its parts name.
    """

    name: str
    title: str
    files: tuple[Path, ...]
    points: dict[str, Point]
    series: dict[str, tuple[str, ...]]
    figures: dict[str, tuple[str, ...]]
    boundaries: tuple[Boundary, ...]
    plots: Mapping[str, FigureSpec] = field(default_factory=dict)
    readings: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    decide: DecideFile | None = None
    pages: bool = False
    plugins: tuple[Plugin, ...] = ()

    @property
    def entries(self) -> dict[str, FigureSpec]:
        """Entries of the figures of the study, by name."""
        return {name: self.plots.get(name) or FIGURES[name] for name in self.figures}

    @property
    def sources(self) -> tuple[Path, ...]:
        """The study file, the files of its parts, and those of the plug-ins beside them."""
        return self.files + tuple(file for plugin in self.plugins for file in plugin.files)

    @property
    def path(self) -> Path:
        """The study file."""
        return self.files[0]

    @property
    def rounds(self) -> int:
        """Maximum number of rounds of refinement after the first."""
        return max((boundary.rounds for boundary in self.boundaries), default=0)
