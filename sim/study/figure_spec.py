"""What a figure is: its kind of plot, the points that feed it, and what its caption says."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from sim.parameters import NUMERICAL, Parameters
from sim.study.plot_kinds import Keys, Shown, find_kind

#: Greatest depth n whose pictures show a portion of the cell: the half near the viewer.
LARGEST_PORTION = 10

#: Profiles of a chute flow end where this share of the spheres' volume is below.
SHARE = 0.995

#: Largest half width of an interval, relative to the mean, of chute flows that a line joins.
WIDEST_INTERVAL = 0.5

#: Flows slower than this (√(gσ)) that are not at rest are said to creep.
CREEP = 0.1

#: Greatest height of the beads in an animation (⟨d⟩); few beads of a gas fly higher.
TALLEST = 24.0


@dataclass(frozen=True)
class FigureSpec:
    """A figure as plain data: numbers, texts, and tuples and mappings of them.

    Attributes
    ----------
    name : str
        Name in study files, targets and file names.
    kind : str
        Kind of plot, see `sim.study.plot_kinds`.
    paper : str
        Figure of the paper it reproduces, or what it is about in it; empty for a study's own plot.
    system : str
        System of all the points that feed it.
    title : str
        One line for tables and the report.
    axes : tuple of str
        Parameters that must take at least two values among those points; curves are drawn along the
        first.
    curves : tuple of str
        Parameters that tell the paper's curves apart; a study may vary them or not.
    alike : tuple of str
        Parameters that do not tell curves apart: points that differ in them are on one curve.
    where : mapping
        Values that parameters of a point must have to be drawn, or tuples of values of which each
        must have one; others of a series that feeds the figure are left out.
    lead : str
        First sentence of the caption: what is drawn.
    named : tuple of str
        Parameters whose values the details give.
    says : str
        Sentence of the caption: what the paper says that the figure shows.
    details : str
        First sentences of the details: definitions and methods.
    series : tuple of str
        Series whose points feed it, where the study says so itself; those of the catalogue are fed
        by the series that name them.
    options : mapping
        What the kind of plot leaves open, such as quantities, and styles that the paper prescribes;
        the module of the kind says which it knows.
    """

    name: str
    kind: str
    paper: str
    system: str
    title: str
    axes: tuple[str, ...] = ()
    curves: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()
    where: Mapping[str, Any] = field(default_factory=dict)
    lead: str = ""
    named: tuple[str, ...] = ()
    says: str = ""
    details: str = ""
    series: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def keys(self) -> Keys:
        """The keys of its kind of plot."""
        return find_kind(self.kind).keys

    @property
    def regimes(self) -> bool:
        """Whether it shows regimes and the boundaries found between them, not velocities."""
        return self.keys.is_map

    @property
    def particles(self) -> Shown:
        """What it shows of the particles, which the dataset then keeps."""
        return self.keys.particles

    @property
    def animated(self) -> bool:
        """Whether it moves: a GIF with a poster instead of a picture."""
        return self.keys.animated

    @property
    def draws_curves(self) -> bool:
        """Whether points are joined to curves, on which each has a place of its own."""
        return bool(self.axes) and not self.regimes

    @property
    def taken(self) -> dict[str, str]:
        """Values in ``where`` in words, by parameter."""
        return {name: ", ".join(map(written, _tuple(value))) for name, value in self.where.items()}

    def shows(self, parameters: Parameters) -> bool:
        """Return whether a point with these parameters is among those drawn."""
        return all(self.takes(name, parameters) for name in self.where)

    def is_fed_by(self, system: str, series: Iterable[str]) -> bool:
        """Return whether a point of some series is one of those that a study's own plot shows."""
        return system == self.system and not set(series).isdisjoint(self.series)

    def takes(self, name: str, parameters: Parameters) -> bool:
        """Return whether a point is not left out for the parameter ``name`` of ``where``."""
        return getattr(parameters, name) in _tuple(self.where[name])

    def place(self, parameters: Parameters) -> tuple[Any, ...]:
        """Return the values that place a point on the curves; points of the same lie on each other.

        Parameters that set how a point is computed do so only where the figure is about them.
        """
        own, others = {*self.axes, *self.curves}, {*NUMERICAL, *self.alike}
        names = type(parameters).model_fields
        return tuple(
            getattr(parameters, name) for name in names if name in own or name not in others
        )

    @property
    def suffixes(self) -> tuple[str, str, str, str]:
        """Of its files: picture, picture that scales or moves, data behind it, caption."""
        return ".png", ".gif" if self.animated else ".svg", ".csv", ".caption.txt"


def _tuple(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def written(value: Any) -> str:
    """Write a value of a parameter for people."""
    return value if isinstance(value, str) else f"{value:g}"
