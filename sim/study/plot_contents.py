"""What a plot shows of a study: points, observables, parameters on its axes."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import log, sqrt
from pathlib import Path
from statistics import median
from typing import Any

from sim.base.errors import Allowed, InputError
from sim.base.messages import near
from sim.parameters import NUMERICAL, SYSTEMS, Parameters, field_info
from sim.study.figure_spec import DataSet, written
from sim.study.measured import PURE, MeasuredTable, read_measured
from sim.study.model import Point
from sim.study.plot_file import MAX_MAGNITUDE, BesideFile, PlotFile, allowed_on_logarithmic
from sim.study.plot_kinds import REGIME
from sim.study.plottable import (
    Observable,
    every_name,
    find_observable,
    require_parameter,
    require_stored,
)


def data_sets(plot: PlotFile, folder: Path, unit_on: Callable[[str], str]) -> tuple[DataSet, ...]:
    """Return the data beside a plot.

    Parameters
    ----------
    plot : PlotFile
        The plot.
    folder : Path
        Folder of its files.
    unit_on : callable
        Function: axis, ``"x"`` or ``"y"`` → its unit as UDUNITS reads it; empty for a natural one.

    Raises
    ------
    InputError
        For a file that cannot be read, and for columns and numbers that cannot be drawn.
    """
    return tuple(
        (data.name, _points(plot, data, folder, unit_on), data.line) for data in plot.beside or ()
    )


def _points(
    plot: PlotFile, data: BesideFile, folder: Path, unit_on: Callable[[str], str]
) -> tuple[tuple[float, ...], ...]:
    """Return the points of one data set."""
    if data.points:
        return tuple(map(tuple, data.points))
    table = read_measured(folder / data.file)
    columns = [_column(plot, table, axis, getattr(data, axis), unit_on(axis)) for axis in "xy"]
    if data.yerr:
        columns.append(_errors(table, data.yerr, unit_on("y")))
    if data.line and len(table.lines) < 2:
        raise InputError.of_value(table.path, "", "1 row", "at least two rows for a line")
    return tuple(zip(*columns, strict=True))


def _column(
    plot: PlotFile, table: MeasuredTable, axis: str, name: str, unit: str
) -> tuple[float, ...]:
    """Return the numbers of a column on an axis with a unit."""
    table.require_column(name, f"for the axis {axis}")
    _require_no_unit(table, name, unit)
    allowed = (
        allowed_on_logarithmic(axis)
        if axis in plot.log
        else f"a number of size up to {MAX_MAGNITUDE:g}"
    )
    low = plot.least(axis)
    return table.numbers(name, unit or PURE, low=low, high=MAX_MAGNITUDE, allowed=allowed)


def _errors(table: MeasuredTable, name: str, unit: str) -> tuple[float, ...]:
    """Return the numbers of a column of errors."""
    table.require_column(name, "the errors of y")
    _require_no_unit(table, name, unit)
    allowed = f"an error in [0, {MAX_MAGNITUDE:g}]"
    return table.numbers(name, unit or PURE, low=0, high=MAX_MAGNITUDE, allowed=allowed)


def _require_no_unit(table: MeasuredTable, name: str, unit: str) -> None:
    """Raise ``InputError`` where a heading has a unit, but the axis a natural one."""
    if table.units[name] and not unit:
        allowed = "no unit, for a plot with units: natural"
        raise InputError.of_value(table.path, f"unit of column {name}", table.units[name], allowed)


#: Maximum number of panels of a plot.
MAX_PANELS = 12

#: What is said of curves that have points of a design.
SCATTER_HINT = "kind: scatter suits a design better"

#: Fewest points of a design, and the share of them above which each would be a curve of its own.
MIN_SCATTERED, SCATTERED_SHARE = 8, 0.6


@dataclass(frozen=True)
class PlotContents:
    """Some points of a study, as a plot at a ``place`` of the file ``source`` shows them."""

    plot: PlotFile
    all_points: Sequence[Point]
    source: str
    place: str

    def error(self, key: str, value: Any, allowed: str | Allowed) -> InputError:
        """Return the error of a key of the plot."""
        return InputError.of_value(self.source, f"{self.place}.{key}", value, allowed)

    @cached_property
    def system(self) -> str:
        """System of the plot: the value of its key, or the only system of its points."""
        systems = list(dict.fromkeys(point.parameters.system for point in self.all_points))
        if self.plot.system is None and len(systems) > 1:
            allowed = "one of " + ", ".join(systems) + ", as the series have several"
            raise self.error("system", None, allowed)
        system = self.plot.system or systems[0]
        if system not in systems:
            allowed = f"a system of its series: {', '.join(systems)}"
            raise self.error("system", system, allowed)
        return system

    @cached_property
    def points(self) -> list[Point]:
        """Points of its system."""
        return [one for one in self.all_points if one.parameters.system == self.system]

    @cached_property
    def parameters(self) -> list[Parameters]:
        """Parameters of these points."""
        return [point.parameters for point in self.points]

    @cached_property
    def observable(self) -> Observable | None:
        """The observable, ``None`` on a map of regimes."""
        if self.plot.observable == REGIME == self.plot.keys.usual:
            return None
        return self._observable(self.plot.keys.observable, self.plot.observable)

    @cached_property
    def second(self) -> Observable | None:
        """The second observable, ``None`` if a parameter is on that axis, or may be.

        A name of neither kind is refused later, with the parameters.
        """
        plot, keys, key = self.plot, self.plot.keys, self.plot.keys.second
        name = getattr(plot, key) if key else None
        if name is None or (key in keys.axes and name not in every_name()):
            return None
        if name == plot.observable:
            raise self.error(key, name, f"an observable other than {keys.observable}")
        return self._observable(key, name)

    @cached_property
    def axes(self) -> tuple[str, ...]:
        """Parameters on its axes."""
        if not self.plot.keys.several:
            return () if self.second else self.plot.axis_names
        named = getattr(self.plot, self.plot.keys.several)
        if named is None:
            named = [name for name in self._varied() if name not in self.groups]
        return tuple(named)

    def _varied(self) -> list[str]:
        """Return the parameters that vary, without a friction of the plane that is no other."""
        names = varying_parameters(self.parameters)
        is_same = all(map(same_plane, self.parameters))
        return [name for name in names if name != "friction_plane" or not is_same]

    @property
    def coloured(self) -> str:
        """The parameter that colours tell apart, empty if it is something else or nothing."""
        name = "" if self.plot.keys.observable == "colour" else self.plot.colour or ""
        return "" if name == REGIME or name in every_name() else name

    @property
    def log(self) -> tuple[str, ...]:
        """Logarithmic axes: those named, and x of curves whose values are spread so."""
        named = tuple(self.plot.log)
        if self.plot.kind != "curves" or not self.axes or "x" in named:
            return named
        values = (getattr(point, self.axes[0]) for point in self.parameters)
        return ("x", *named) if has_logarithmic_values(values) else named

    @cached_property
    def suits_scatter(self) -> bool:
        """Whether curves would have hardly more than one point each, as those of a design."""
        plot, points = self.plot, self.parameters
        if plot.kind != "curves" or not self.axes or len(points) < MIN_SCATTERED:
            return False
        names = [name for name in self._varied() if name not in self.axes]
        groups = {tuple(getattr(point, name) for name in names) for point in points}
        return len(groups) > SCATTERED_SHARE * len(points)

    @property
    def groups(self) -> tuple[str, ...]:
        """Parameters that tell curves and panels apart."""
        return (*(self.plot.curves or ()), *([self.plot.panels] if self.plot.panels else ()))

    @cached_property
    def beside(self) -> tuple[DataSet, ...]:
        """Data that are not of the study."""
        return data_sets(self.plot, Path(self.source).parent, self._unit_on)

    def _unit_on(self, axis: str) -> str:
        """Return the unit of an axis as UDUNITS reads it; empty for a natural one."""
        keys = self.plot.keys
        named: dict[str, Observable | None] = {
            keys.observable: self.observable,
            keys.second: self.second,
        }
        if getattr(self.plot, axis) in self.axes:
            unit = field_info(SYSTEMS[self.system])[getattr(self.plot, axis)].unit
        else:
            observable = named.get(axis)
            # Profiles without an observable there have the height.
            unit = observable.unit if observable else "m"
            if self.plot.units == "natural" and unit != PURE:
                return ""
        return unit

    def require_drawable(self) -> None:
        """Raise ``InputError`` for what the points do not keep or vary, or what hides a point."""
        places: dict[str, str] = {}
        named = self._parameters_by_key()
        for key, name in named:
            keys = self.plot.keys
            alternatives = keys.shows(self.system) if key == keys.second else ()
            varied = varying_parameters(self.parameters)
            require_parameter(key, name, self.system, alternatives, self.error, varied)
            self._require_varied(key, name)
        for key, name in named:
            if name in places:
                raise self.error(key, name, f"a parameter other than {places[name]}")
            places[name] = key
        self._require_few_panels()
        self._require_few_axes()
        self._require_colour()
        self._require_logarithms()
        self._require_distinct_map_points()

    def _observable(self, key: str, name: str) -> Observable:
        """Return the observable that a key of the plot names, if its points keep it."""
        observable = find_observable(self.plot.kind, key, name, self.system, self.error)
        require_stored(observable, self.points, partial(self.error, key, name))
        return observable

    def _parameters_by_key(self) -> list[tuple[str, str]]:
        """Return pairs of a key of the plot and the parameter that it names."""
        plot = self.plot
        axes = [(key, getattr(plot, key)) for key in ("x", "y") if getattr(plot, key) in self.axes]
        curves = [
            (f"curves[{number}]" if len(plot.curves or []) > 1 else "curves", name)
            for number, name in enumerate(plot.curves or [])
        ]
        several = [
            (f"{plot.keys.several}[{number}]", name)
            for number, name in enumerate(self.axes if plot.keys.several else ())
        ]
        others = [("panels", plot.panels or ""), ("colour", self.coloured)]
        return [*axes, *several, *curves, *((key, name) for key, name in others if name)]

    def _require_varied(self, key: str, name: str) -> None:
        values = {getattr(point, name) for point in self.parameters}
        if len(values) < 2:
            vary = varying_parameters(self.parameters)
            allowed = "a parameter that the points vary" + (f": {near(name, vary)}" if vary else "")
            got = f"{name}, which is {_value_text(values.pop())} throughout"
            raise self.error(key, got, allowed)

    def _require_few_panels(self) -> None:
        if self.plot.panels:
            count = len({getattr(point, self.plot.panels) for point in self.parameters})
            if count > MAX_PANELS:
                allowed = f"a parameter of at most {MAX_PANELS} values"
                raise self.error("panels", f"{self.plot.panels} with {count} values", allowed)

    def _require_few_axes(self) -> None:
        """Raise an error for more axes than there is room for, or for none."""
        key, most = self.plot.keys.several, self.plot.keys.most
        if key and not 0 < len(self.axes) <= most:
            got = ", ".join(self.axes) or None
            raise self.error(key, got, f"1 to {most} parameters that the points vary")

    def _require_colour(self) -> None:
        """Raise an error for a colour that shows an observable which the points do not keep."""
        name = self.plot.colour
        if self.plot.keys.observable != "colour" and name in every_name():
            self._observable("colour", name)

    def _require_logarithms(self) -> None:
        """Raise an error for a logarithmic axis whose parameter is zero or less at some point."""
        for number, axis in enumerate(self.plot.log):
            name = getattr(self.plot, axis)
            if name in (*self.axes, self.coloured):
                if not _is_number(self.system, name):
                    raise self.error(f"log[{number}]", axis, f"no log, as {name} is no number")
                least = min(getattr(point, name) for point in self.parameters)
                if least <= 0:
                    got = f"{axis} with {name} = {written(least)}"
                    allowed = f"an axis of values > 0, or no log of {axis}"
                    raise self.error(f"log[{number}]", got, allowed)

    def _require_distinct_map_points(self) -> None:
        """Raise an error for a map that would draw several points at one position."""
        shown = (*self.axes, *self.groups)
        points_by_position: dict[tuple[Any, ...], Parameters] = {}
        for point in self.parameters if self.plot.keys.is_map else ():
            position = tuple(getattr(point, name) for name in shown)
            other = points_by_position.setdefault(position, point)
            if other is not point:
                vary = varying_parameters([other, point])
                differences = ", ".join(name for name in vary if name not in shown) or "numerics"
                allowed = f"a map with one point at each place: these differ in {differences}"
                raise self.error("panels", self.plot.panels, allowed)


def varying_parameters(points: Sequence[Parameters]) -> list[str]:
    """Return the parameters that points of one system vary, except numerical ones."""
    return [
        name
        for name in type(points[0]).model_fields
        if name not in NUMERICAL and len({getattr(point, name) for point in points}) > 1
    ]


#: Ratio of the ends of a parameter from which its axis may be logarithmic.
_WIDE = 8.0


def has_logarithmic_values(values: Iterable[float]) -> bool:
    """Return whether values spread over a wide range evenly in their logarithm."""
    known = list(values)
    low, middle, high = min(known), median(known), max(known)
    if low <= 0 or high < _WIDE * low:
        return False
    geometric, arithmetic = sqrt(low * high), (low + high) / 2
    return abs(log(middle / geometric)) < abs(log(middle / arithmetic))


def same_plane(point: Parameters) -> bool:
    """Return whether the plane has no friction of its own."""
    return getattr(point, "friction_plane", 0) == getattr(point, "friction", 0)


def _is_number(system: str, name: str) -> bool:
    return SYSTEMS[system].model_fields[name].annotation in (int, float)


def _value_text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else written(value)


def parameter_phrase(system: str, name: str) -> str:
    """Return the name of a parameter in words, with its symbol."""
    row = field_info(SYSTEMS[system])[name]
    return f"{name_in_words(name)} {row.symbol}".strip()


def name_in_words(name: str) -> str:
    """Return a name from a study file in words."""
    return name.replace("_", " ")


def in_words(names: Iterable[str]) -> str:
    """Return names as a list in words: ``a``, ``a and b``, ``a, b and c``."""
    *first, last = [*names] or [""]
    return f"{', '.join(first)} and {last}" if first else last


#: Most parameters that a title names.
_MOST_NAMED = 3


def default_title(contents: PlotContents) -> str:
    """Return the default title of a plot, such as ``Velocity against friction, by angle``."""
    plot = contents.plot
    vertical, horizontal = _y_then_x(contents)
    what = plot.keys.what.format(name_in_words(vertical.name)) if vertical else "regimes"
    names = [horizontal.name] if horizontal else contents.axes
    if len(names) > _MOST_NAMED:
        over = plot.keys.over.format(f"{len(names)} parameters")
    else:
        over = _over_phrase(plot, list(map(name_in_words, names)), horizontal)
    colour = [] if plot.keys.observable == "colour" else [plot.colour]
    groups = [name for name in (*(plot.curves or []), *colour, plot.panels) if name]
    title = f"{what} {over}" + (f", by {in_words(map(name_in_words, groups))}" if groups else "")
    return title[0].upper() + title[1:]


def caption_lead(contents: PlotContents) -> str:
    """Return the first sentence of the caption of a plot."""
    plot, system = contents.plot, contents.system
    vertical, horizontal = _y_then_x(contents)
    what = (
        f"{name_in_words(vertical.name).capitalize()}: {vertical.meaning}"
        if vertical
        else "Regimes"
    )
    against = (
        [f"{name_in_words(horizontal.name)} ({horizontal.meaning})"]
        if horizontal
        else [parameter_phrase(system, name) for name in contents.axes]
    )
    parts = [f"{what}, {_over_phrase(plot, against, horizontal)}"]
    if plot.curves:
        parts.append("curves: " + ", ".join(parameter_phrase(system, name) for name in plot.curves))
    if plot.colour and plot.keys.observable != "colour":
        coloured = contents.coloured
        colour = parameter_phrase(system, coloured) if coloured else name_in_words(plot.colour)
        parts.append(f"colour: {colour}")
    if plot.panels:
        parts.append(f"panels: {parameter_phrase(system, plot.panels)}")
    return "; ".join(parts) + "."


def _y_then_x(contents: PlotContents) -> tuple[Observable | None, Observable | None]:
    """Return both observables as (y, x)."""
    observable, second = contents.observable, contents.second
    is_turned = second and contents.plot.keys.second == "y"
    return (second, observable) if is_turned else (observable, second)


def _over_phrase(plot: PlotFile, names: list[str], horizontal: Observable | None) -> str:
    """Return the part of a title that begins with "over" or "against"."""
    pattern = plot.keys.over if horizontal is None else "against {}"
    return pattern.format(in_words(names))
