"""What a study is: points, boundaries to be found, figures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sim.base.additions import Plugin
from sim.parameters import Parameters
from sim.study.catalogue import FIGURES, FigureSpec
from sim.study.entries import DecideFile
from sim.study.refine import further_rounds


@dataclass(frozen=True)
class Point:
    """One run of a study, however many series and figures it serves.

    ``left_out`` are figures that its series feed and that do not show it.
    """

    id: str
    parameters: Parameters
    series: tuple[str, ...]
    figures: tuple[str, ...]
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Boundary:
    """One boundary to be found, all parameters but one fixed.

    Attributes
    ----------
    name : str
        Shared by the boundaries of one entry of the study file, which its ``grid`` tells apart.
    of, along : str
        What changes at the boundary; the parameter along which it is looked for.
    low, high, tolerance : float
        Range of that parameter and width of the interval wanted.
    grid : dict
        Values of the grid that this boundary is for.
    figures : tuple of str
        Figures that it feeds.
    at : callable
        Gives the parameters of the point at a value of ``along``.
    """

    name: str
    of: str
    along: str
    low: float
    high: float
    tolerance: float
    grid: dict[str, Any]
    figures: tuple[str, ...]
    at: Callable[[float], Parameters]

    @property
    def rounds(self) -> int:
        """Rounds of refinement after the first."""
        return further_rounds(self.low, self.high, self.tolerance)


@dataclass(frozen=True)
class Study:
    """A validated study.

    Attributes
    ----------
    name, title : str
        Name of the folder of results; one line for the report.
    files : tuple of Path
        The study file, then those of its parts.
    points : dict
        Points by id, in the order of the file; equal points of several series appear once. Of the
        boundaries, the first round.
    series, figures : dict
        Ids of the points of each series (or boundary) and of each figure, in order.
    boundaries : tuple of Boundary
        Boundaries to be found.
    plots : mapping
        Its own plots, by name, as entries like those of the catalogue; they are among ``figures``.
    readings : mapping
        By system the readings of its paper under which every series is run, each as what differs
        from the defaults.
    decide : DecideFile or None
        What is to be decided by more replicates; those bought so far are in the points' parameters.
    pages : bool
        Whether each of its points, those of later rounds aside, has a page.
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
        """What each figure of the study is, by name."""
        return {name: self.plots.get(name) or FIGURES[name] for name in self.figures}

    @property
    def sources(self) -> tuple[Path, ...]:
        """The study file, those of its parts, and the plug-ins that are files beside them."""
        return self.files + tuple(Path(one.place) for one in self.plugins if one.is_file)

    @property
    def path(self) -> Path:
        """The study file."""
        return self.files[0]

    @property
    def rounds(self) -> int:
        """Rounds of refinement after the first that the boundaries may take."""
        return max((boundary.rounds for boundary in self.boundaries), default=0)
