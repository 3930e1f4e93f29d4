"""Kinds of plot: what a kind is, and the call that declares one, for Talus and for plug-ins alike.

Those that ship stand in `sim.figures.kinds`. Nothing imports it by a statement.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import wraps
from importlib import import_module
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from sim.base.additions import (
    AdditionError,
    add,
    additions,
    attribute_errors_to,
    is_of_talus,
    shipped,
)
from sim.base.errors import in_short, printable
from sim.base.plugins import require_function, require_one_of, with_declared_types
from sim.parameters import NUMERICAL, SYSTEMS, Parameters

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: Kind of the additions that are kinds of plot, and package of those that ship.
PLOT, SHIPPED = "plot", "sim.figures.kinds"

#: Value of the key of the observable that is none: a map of regimes.
REGIME = "regime"

#: Function of the data of a figure, `sim.figures.data.FigureData`.
OfData = Callable[[Any], Any]

#: Function: data of a figure → picture.
Drawing = Callable[[Any], "Figure"]


#: What functions of a plug-in return: a method or attribute of it, and in words.
_RETURNED = {
    "draw": ("savefig", "a figure of matplotlib"),
    "table": ("to_csv", "a pandas.DataFrame"),
    "select": ("rows", "the data of a figure"),
}


class Shown(IntEnum):
    """What is shown of the particles of a point, the later the more of them is kept."""

    NOTHING = 0
    STATE = 1
    PATH = 2


@dataclass(frozen=True)
class Keys:
    """The keys that a kind of plot takes, and what they name.

    Attributes
    ----------
    axes : tuple of str
        Keys of the parameters on its axes.
    observable : str
        Key of the observable; empty for a kind of papers' figures alone.
    usual : str
        What is shown where this key is omitted.
    shows : callable
        Function: system → observables that can be shown (`sim.study.plottable`), by name.
    second : str
        Key of a second observable, for a kind that can show one against another.
    several : str
        Key of a list of parameters, of which each has an axis; all that vary where it is omitted.
    most : int
        Most parameters in that list.
    log : tuple of str
        Axes that can be logarithmic.
    others : tuple of str
        Further keys.
    of_papers : tuple of str
        Keys of papers' figures, where these take others; `sim.study.catalogue` says what they mean.
    systems : tuple of str
        Systems of which papers can have figures of the kind, empty for all.
    what, over : str
        What titles make of the name of the observable, and what they say of the axes.
    particles : Shown
        What it shows of the particles, which the dataset then keeps.
    animated, from_runs : bool
        Whether it moves, and whether it reads run files.
    """

    axes: tuple[Literal["x", "y"], ...] = ()
    observable: Literal["", "x", "y", "colour"] = ""
    usual: str = "velocity"
    shows: Callable[[str], Mapping[str, Any]] = lambda system: {}
    second: Literal["", "x", "y"] = ""
    several: Literal["", "parameters"] = ""
    most: int = 12
    log: tuple[Literal["x", "y", "colour"], ...] = ()
    others: tuple[Literal["curves", "colour", "panels", "between", "beside", "fit"], ...] = ()
    of_papers: tuple[str, ...] = ()
    systems: tuple[str, ...] = ()
    what: str = "{}"
    over: str = "against {}"
    particles: Shown = Shown.NOTHING
    animated: bool = False
    from_runs: bool = False

    @property
    def every(self) -> tuple[str, ...]:
        """All keys of a study's plot of the kind, besides those of all kinds."""
        named = *self.axes, self.several, self.observable, self.second, *self.others
        return tuple(dict.fromkeys(filter(None, named)))

    @property
    def is_map(self) -> bool:
        """Whether both axes are parameters, so that each point has a place of its own."""
        return len(self.axes) == 2


def _point_table(data: Any) -> "pd.DataFrame":
    return resolve_name("sim.figures.data:point_table")(data)


def _point_notes(data: Any) -> list[str]:
    return resolve_name("sim.figures.caption:point_notes")(data)


@dataclass(frozen=True)
class PlotKind:
    """A kind of plot: its keys, and functions of the data of a figure, which include its entry.

    Attributes
    ----------
    keys : Keys
        The keys that it takes.
    draw : callable
        Returns the picture or the animation.
    table : callable
        Returns the data behind the picture, units in the headings.
    notes : callable
        Returns the sentences of the caption on error bars, markers and the like.
    select : callable
        Returns the data with the points to draw only; gets at least one point.
    """

    keys: Keys
    draw: OfData = field(repr=False)
    table: "Callable[[Any], pd.DataFrame]" = _point_table
    notes: Callable[[Any], list[str]] = _point_notes
    select: OfData = lambda data: data


def plot_kind(
    name: str,
    *,
    like: str = "",
    keys: Keys | None = None,
    table: "Callable[[Any], pd.DataFrame] | None" = None,
    notes: Callable[[Any], Sequence[str]] | None = None,
    select: OfData | None = None,
) -> Callable[[Drawing], Drawing]:
    """Declare a kind of plot; the decorated function draws it.

    The function gets the data of a figure: its ``spec``, a table ``rows`` of its points, and the
    ``results`` of the study. It returns a matplotlib figure.

    Parameters
    ----------
    name : str
        The ``kind`` that study files give.
    like : str
        Kind of Talus whose keys it takes, where it has no ``keys`` of its own; the same checks
        apply.
    keys : Keys, optional
        The keys that it takes.
    table, notes : callable, optional
        Functions that return the data behind the picture, and the sentences of the caption. By
        default, those of ``like``.
    select : callable, optional
        Function that returns the data with the points to draw only.
    """
    given = {"table": table, "notes": notes, "select": select}
    functions = {role: function for role, function in given.items() if function is not None}
    if keys is None:
        require_one_of(f"plot {name}: like", like, study_kinds())
        base = find_kind(like)
        # Nothing draws data beside the plot of a plug-in, or fits a law to it.
        others = tuple(key for key in base.keys.others if key not in ("beside", "fit"))
        base = replace(base, keys=replace(base.keys, others=others))
    elif like or not isinstance(keys, Keys):
        raise AdditionError(
            f"plot {name}: keys is of type Keys, without like: got {in_short(keys)}"
        )
    elif not is_of_talus():
        keys = _usable(f"plot {name}: keys", keys)
    for role, function in functions.items():
        require_function(f"plot {name}: {role}", function, takes=1)
    if notes:
        functions["notes"] = lambda data: [printable(note) for note in notes(data)]

    def register(draw: Drawing) -> Drawing:
        require_function(f"plot {name}", draw, takes=1)
        own: dict[str, Any] = {
            role: _attributed(name, role, one) for role, one in (functions | {"draw": draw}).items()
        }
        add(PLOT, name, replace(base, **own) if keys is None else PlotKind(keys, **own))
        return draw

    return register


def _usable(what: str, keys: Keys) -> Keys:
    """Return the keys of a plug-in's kind; refuse values that no plot has, or that nothing draws.

    Raises
    ------
    AdditionError
        For the first of them, with the attribute of `Keys` and what is allowed.
    """

    def require(key: str, value: Any, allowed: str, *, holds: bool) -> None:
        if not holds:
            raise AdditionError(f"{what}.{key}: got {in_short(value)}; allowed: {allowed}")

    keys = with_declared_types(what, keys)
    once = len(set(keys.axes)) == len(keys.axes) and keys.observable not in keys.axes
    require("axes", keys.axes, "each key once, and not that of the observable", holds=once)
    second = not keys.second or keys.second != keys.observable
    require("second", keys.second, "another key than that of the observable", holds=second)
    has_colour = keys.observable == "colour" or "colour" not in keys.log
    require("log", keys.log, "colour only where it is the key of the observable", holds=has_colour)
    # Nothing draws data beside the plot of a plug-in.
    require("others", keys.others, "curves, panels, between", holds="beside" not in keys.others)
    for name in keys.systems:
        require("systems", name, f"one of {', '.join(SYSTEMS)}", holds=name in SYSTEMS)
    for key in ("what", "over"):
        text = getattr(keys, key)
        is_pattern = text.isprintable() and not set("{}") & set(text.replace("{}", "", 1))
        require(key, text, "one line of text, with {} for the names", holds=is_pattern)
    for system in SYSTEMS:
        shown = keys.shows(system)
        are_observables = isinstance(shown, Mapping) and all(
            isinstance(name, str) and hasattr(one, "meaning") for name, one in shown.items()
        )
        allowed = "a function: system -> observables by name, as talus.study.plottable.numbers"
        require("shows", shown, allowed, holds=are_observables)
    return keys


def _attributed(name: str, role: str, function: OfData) -> OfData:
    """Return a function whose errors name the plug-in of a kind, and its place there."""
    method, what = ("", "") if is_of_talus() else _RETURNED.get(role, ("", ""))

    @wraps(function)
    def call(data: Any) -> Any:
        with attribute_errors_to(PLOT, name, f" {data.spec.name}"):
            answer = function(data)
            if method and not hasattr(answer, method):
                raise TypeError(f"{role} returns {what}: got {in_short(answer)}")
            return answer

    return call


def kinds() -> Mapping[str, PlotKind]:
    """Return all kinds of plot by name: those that ship, then those of plug-ins."""
    import_module(SHIPPED)
    return {
        **dict(sorted(shipped(PLOT).items())),
        **{name: addition.value for name, addition in additions(PLOT).items()},
    }


def find_kind(name: str) -> PlotKind:
    """Return the kind of plot with a name."""
    return kinds()[name]


def study_kinds(*, own: bool = False) -> list[str]:
    """Return the names of the kinds of studies' plots, with ``own`` those of plug-ins, too."""
    return [
        name
        for name, kind in kinds().items()
        if kind.keys.observable and (own or name in shipped(PLOT))
    ]


def plugin_code(kind: str) -> str:
    """Return the code hash of a kind's plug-in; empty for the kinds of Talus."""
    plots = additions(PLOT)
    return plots[kind].plugin.code if kind in plots else ""


#: Greatest depth n whose pictures show a portion of the cell: the half near the viewer.
LARGEST_PORTION = 10

#: Profiles of a chute flow end where this share of the spheres' volume is below.
SHARE = 0.995

#: Flows slower than this (√(gσ)) that are not at rest are said to creep.
CREEP = 0.1

#: Greatest height of the beads in an animation (⟨d⟩); few beads of a gas fly higher.
TALLEST = 24.0


class Answer(NamedTuple):
    """The answer that a figure shows: its file, and the observable with its unit.

    ``regimes`` are those that count, ``settings`` those of the question, and ``x`` and ``y`` the
    parameters on the axes.
    """

    file: str = ""
    observable: str = ""
    unit: str = ""
    regimes: tuple[str, ...] = ()
    settings: tuple[Any, ...] = ()
    x: str = ""
    y: str = ""


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
    show, second, colour : str
        The observable that is shown; a second one, where no parameter is on its axis; and what
        colours show. Each may be empty.
    by, panels : tuple of str, str
        Parameters that the keys ``curves`` and ``panels`` name.
    units : str
        Units of observables, ``"si"`` or ``"natural"``.
    log : tuple of str
        Logarithmic axes.
    between : tuple of float
        Lowest and highest height of profiles, in diameters; empty for all.
    beside : tuple
        Data that are not of the study: label, points (x, y) or (x, y, error of y) in the units of
        the axes, and whether a line joins them.
    fit : str
        Law that is fitted to each curve.
    scattered : bool
        Whether points hardly share curves, as those of a design.
    labels : mapping
        Labels of the axes ``"x"`` and ``"y"``, in place of names and units.
    levels, level : tuple of float, str
        Values to compare with, and their entry in the legend.
    quantities : tuple of mapping
        Measures of the dataset that are shown in place of the velocity.
    styles, entry : mapping, str
        Looks of curves by the values of their parameters, and pattern of the other entries.
    point : str
        Which of several points is shown.
    widest : float
        Largest half width of an interval, relative to its value, that a line joins; 0 for any.
    relative : bool
        Whether velocity and frequency of the belt are shares of its own.
    flat : bool
        Whether profiles have the height along x, and end where particles are few.
    theory, creep : str, bool
        Line of theory on a map of regimes, and whether its flows that creep have a marker.
    answer : Answer
        The answer that it shows.
    plugin : str
        Code hash of the plug-in that adds its kind.
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
    show: str = ""
    second: str = ""
    colour: str = ""
    by: tuple[str, ...] = ()
    panels: str = ""
    units: str = "si"
    log: tuple[str, ...] = ()
    between: tuple[float, ...] = ()
    beside: tuple[Any, ...] = ()
    fit: str = ""
    scattered: bool = False
    labels: Mapping[str, str] = field(default_factory=dict)
    levels: tuple[float, ...] = ()
    level: str = ""
    quantities: tuple[Mapping[str, str], ...] = ()
    styles: Mapping[Any, Mapping[str, str]] = field(default_factory=dict)
    entry: str = ""
    point: str = ""
    widest: float = 0.0
    relative: bool = False
    flat: bool = False
    theory: str = ""
    creep: bool = False
    answer: Answer = field(default_factory=Answer)
    plugin: str = ""

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
