"""What a plot shows of a study: points, observables, parameters on its axes."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from sim.base.errors import Allowed, InputError
from sim.base.measured import PURE, MeasuredTable, read_measured
from sim.base.messages import near
from sim.parameters import NUMERICAL, SYSTEMS, Parameters, field_info
from sim.study.design import axis_of
from sim.study.figure_spec import DataSet, FigureSpec, written
from sim.study.model import Point
from sim.study.plot_file import MAX_MAGNITUDE, BesideFile, PlotFile, allowed_on_logarithmic
from sim.study.plottable import (
    REGIME,
    Observable,
    every_name,
    find_observable,
    require_parameter,
    require_stored,
)

#: Maximum number of panels of a plot, and what is said of curves that have points of a design.
MAX_PANELS, SCATTER_HINT = 12, "kind: scatter suits a design better"

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
            allowed = f"one of {', '.join(systems)}, as the series have several"
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
    def spec(self) -> FigureSpec:
        """The plot with its system, and all parameters that vary where it shows several of them."""
        spec = FigureSpec.model_construct(**vars(self.plot) | {"system": self.system})
        if not spec.keys.several or spec.parameters is not None:
            return spec
        names = [one for one in varying_parameters(self.parameters) if one not in spec.groups]
        return spec.model_copy(update={"parameters": names})

    @cached_property
    def observables(self) -> dict[str, Observable]:
        """The observables that it shows, by key; its points keep them.

        A name of no observable is refused with the parameters.
        """
        spec, keys = self.spec, self.spec.keys
        shows_regimes = spec.show == REGIME == keys.usual
        named: dict[str, str] = {} if shows_regimes else {keys.observable: spec.show}
        for key in filter(None, (keys.second, "colour")):
            name, may_be_parameter = getattr(spec, key), key in (*keys.axes, "colour")
            if name and (name in every_name() or not may_be_parameter) and key != keys.observable:
                if key == keys.second and name == spec.show:
                    raise self.error(key, name, f"an observable other than {keys.observable}")
                named[key] = name
        found: dict[str, Observable] = {}
        for key, name in named.items():
            found[key] = find_observable(spec.kind, key, name, self.system, self.error)
            require_stored(found[key], self.points, partial(self.error, key, name))
        return found

    @property
    def coloured(self) -> str:
        """The parameter that colours tell apart, empty if it is something else or nothing."""
        keys, name = self.spec.keys, self.spec.colour or ""
        is_other = keys.observable == "colour" or "colour" in self.observables or name == REGIME
        return "" if is_other else name

    @property
    def log(self) -> list[str]:
        """Logarithmic axes: those named, and x of curves whose values are spread so."""
        spec, named = self.spec, list[str](self.plot.log)
        if spec.kind != "curves" or not spec.axes or "x" in named:
            return named
        values = (getattr(point, spec.axes[0]) for point in self.parameters)
        return ["x", *named] if has_logarithmic_values(values) else named

    @cached_property
    def suits_scatter(self) -> bool:
        """Whether curves would have hardly more than one point each, as those of a design."""
        axes, points = self.spec.axes, self.parameters
        if self.spec.kind != "curves" or not axes or len(points) < MIN_SCATTERED:
            return False
        names = [name for name in varying_parameters(points) if name not in axes]
        groups = {tuple(getattr(point, name) for name in names) for point in points}
        return len(groups) > SCATTERED_SHARE * len(points)

    @cached_property
    def beside(self) -> tuple[DataSet, ...]:
        """Data that are not of the study."""
        return tuple((one.name, self._points(one), one.line) for one in self.plot.beside or ())

    def _points(self, data: BesideFile) -> tuple[tuple[float, ...], ...]:
        if data.points:
            return tuple(map(tuple, data.points))
        table = read_measured(Path(self.source).parent / data.file)
        columns = [self._column(table, axis, getattr(data, axis)) for axis in "xy"]
        if data.yerr:
            columns.append(self._column(table, "y", data.yerr, are_errors=True))
        if data.line and len(table.lines) < 2:
            raise InputError.of_value(table.path, "", "1 row", "at least two rows for a line")
        return tuple(zip(*columns, strict=True))

    def _column(
        self, table: MeasuredTable, axis: str, name: str, are_errors: bool = False
    ) -> tuple[float, ...]:
        """Return the numbers of a column on an axis, or errors of such."""
        plot, unit = self.plot, self._unit_on(axis)
        table.require_column(name, "the errors of y" if are_errors else f"for the axis {axis}")
        if (own := table.units[name]) and not unit:
            allowed = "no unit, for a plot with units: natural"
            raise InputError.of_value(table.path, f"unit of column {name}", own, allowed)
        low, allowed = plot.least(axis), f"a number of size up to {MAX_MAGNITUDE:g}"
        if axis in plot.log:
            allowed = allowed_on_logarithmic(axis)
        if are_errors:
            low, allowed = 0, f"an error in [0, {MAX_MAGNITUDE:g}]"
        return table.numbers(name, unit or PURE, low=low, high=MAX_MAGNITUDE, allowed=allowed)

    def _unit_on(self, axis: str) -> str:
        """Return the unit of an axis as UDUNITS reads it; empty for a natural one."""
        name = getattr(self.plot, axis)
        if name in self.spec.axes:
            return field_info(SYSTEMS[self.system])[name].unit
        # Profiles without an observable there have the height.
        unit = self.observables[axis].unit if axis in self.observables else "m"
        return "" if self.plot.units == "natural" and unit != PURE else unit

    def require_drawable(self) -> None:
        """Raise ``InputError`` for what the points do not keep or vary, or what hides a point."""
        spec, places, varied = self.spec, dict[str, str](), varying_parameters(self.parameters)
        named = self._parameters_by_key()
        for key, name in named:
            alternatives = spec.keys.shows(self.system) if key == spec.keys.second else ()
            require_parameter(key, name, self.system, alternatives, self.error, varied)
            values = {getattr(point, name) for point in self.parameters}
            if len(values) < 2:
                allowed = "a parameter that the points vary"
                allowed += f": {near(name, varied)}" if varied else ""
                got = f"{name}, which is {written(values.pop())} throughout"
                raise self.error(key, got, allowed)
        for key, name in named:
            if places.setdefault(name, key) != key:
                raise self.error(key, name, f"a parameter other than {places[name]}")
        if spec.panels:
            count = len({getattr(point, spec.panels) for point in self.parameters})
            if count > MAX_PANELS:
                allowed = f"a parameter of at most {MAX_PANELS} values"
                raise self.error("panels", f"{spec.panels} with {count} values", allowed)
        if (key := spec.keys.several) and not 0 < len(spec.axes) <= spec.keys.most:
            allowed = f"1 to {spec.keys.most} parameters that the points vary"
            raise self.error(key, ", ".join(spec.axes) or None, allowed)
        self._require_logarithms()
        self._require_distinct_map_points()

    def _parameters_by_key(self) -> list[tuple[str, str]]:
        """Return pairs of a key of the plot and the parameter that it names."""
        spec, keys = self.spec, self.spec.keys
        # Observables are refused before parameters.
        axes = set[str](keys.axes) - set(self.observables)
        named = [(key, getattr(spec, key)) for key in sorted(axes)]
        several = enumerate(spec.axes if keys.several else ())
        named += [(f"{keys.several}[{number}]", name) for number, name in several]
        curves = "curves[{}]" if len(spec.by) > 1 else "curves"
        named += [(curves.format(number), name) for number, name in enumerate(spec.by)]
        named += [("panels", spec.panels or ""), ("colour", self.coloured)]
        return [(key, name) for key, name in named if name]

    def _require_logarithms(self) -> None:
        for number, axis in enumerate(self.plot.log):
            name = getattr(self.plot, axis)
            if name in (*self.spec.axes, self.coloured):
                if SYSTEMS[self.system].model_fields[name].annotation not in (int, float):
                    raise self.error(f"log[{number}]", axis, f"no log, as {name} is no number")
                least = min(getattr(point, name) for point in self.parameters)
                if least <= 0:
                    got = f"{axis} with {name} = {written(least)}"
                    allowed = f"an axis of values > 0, or no log of {axis}"
                    raise self.error(f"log[{number}]", got, allowed)

    def _require_distinct_map_points(self) -> None:
        shown = (*self.spec.axes, *self.spec.groups)
        points_by_position: dict[tuple[Any, ...], Parameters] = {}
        for point in self.parameters if self.spec.keys.is_map else ():
            position = tuple(getattr(point, name) for name in shown)
            other = points_by_position.setdefault(position, point)
            if other is not point:
                vary = varying_parameters([other, point])
                differences = ", ".join(name for name in vary if name not in shown) or "numerics"
                allowed = f"a map with one point at each place: these differ in {differences}"
                raise self.error("panels", self.plot.panels, allowed)


def varying_parameters(points: Sequence[Parameters]) -> list[str]:
    """Return the parameters that points of one system vary, except numerical ones.

    The friction of the plane is none of them where it is everywhere that of the particles.
    """
    names = [name for name in type(points[0]).model_fields if name not in NUMERICAL]
    values = {name: [getattr(point, name) for point in points] for name in names}
    is_same = values.get("friction_plane") == values.get("friction")
    varied = [name for name in names if len(set(values[name])) > 1]
    return [name for name in varied if name != "friction_plane" or not is_same]


def has_logarithmic_values(values: Iterable[float]) -> bool:
    """Return whether values spread over a wide range evenly in their logarithm."""
    axis = axis_of("", values, is_integer=False)
    return axis.scale == "log" and axis.high >= 8 * axis.low


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


def default_title(contents: PlotContents) -> str:
    """Return the default title of a plot, such as ``Velocity against friction, by angle``."""
    spec, names = contents.spec, list(map(name_in_words, contents.spec.axes))
    vertical, horizontal, over = _shown(contents)
    what = spec.keys.what.format(name_in_words(vertical.name)) if vertical else "regimes"
    if horizontal:
        names = [name_in_words(horizontal.name)]
    elif len(names) > 3:
        names = [f"{len(names)} parameters"]
    colour = "" if spec.keys.observable == "colour" else spec.colour
    groups = [name_in_words(name) for name in (*spec.by, colour, spec.panels) if name]
    by = f", by {in_words(groups)}" if groups else ""
    return f"{what[0].upper()}{what[1:]} {over.format(in_words(names))}{by}"


def caption_lead(contents: PlotContents) -> str:
    """Return the first sentence of the caption of a plot."""
    spec, phrase = contents.spec, partial(parameter_phrase, contents.system)
    vertical, horizontal, over = _shown(contents)
    what, against = "Regimes", [phrase(name) for name in spec.axes]
    if vertical:
        what = f"{name_in_words(vertical.name).capitalize()}: {vertical.meaning}"
    if horizontal:
        against = [f"{name_in_words(horizontal.name)} ({horizontal.meaning})"]
    groups = {"curves": ", ".join(map(phrase, spec.by))}
    if (colour := spec.colour) and spec.keys.observable != "colour":
        groups["colour"] = phrase(colour) if contents.coloured else name_in_words(colour)
    groups["panels"] = phrase(spec.panels) if spec.panels else ""
    said = [f"; {key}: {names}" for key, names in groups.items() if names]
    return f"{what}, {over.format(in_words(against))}{''.join(said)}."


def _shown(contents: PlotContents) -> tuple[Observable | None, Observable | None, str]:
    """Return what is shown, the observable that it is against, if any, and how that is said."""
    shown, keys = contents.observables, contents.spec.keys
    if "x" in shown and "y" in shown:
        return shown["y"], shown["x"], "against {}"
    return shown.get(keys.observable), None, keys.over
