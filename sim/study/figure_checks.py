"""Checks of figures and plots whose keys are valid: they must suit the points."""

from collections.abc import Sequence
from typing import Any

from sim.base.errors import InputError
from sim.parameters import NUMERICAL, Parameters
from sim.study.figure_spec import FigureSpec, written
from sim.study.model import Point
from sim.study.plot_file import PlotFile
from sim.study.plottable import SHOWN_BY, PlotErrorMaker, require_parameter

#: Maximum number of panels of a plot.
MAX_PANELS = 12


def require_points_vary(
    spec: FigureSpec, figure_points: Sequence[Point], source: str, path: str
) -> None:
    """Raise ``InputError`` for a figure without points, or whose points do not vary its axes."""
    if not figure_points:
        conditions = ", ".join(f"{key} {values}" for key, values in spec.taken.items())
        raise InputError.of_value(source, path, spec.name, f"series with a point at {conditions}")
    for axis in spec.axes:
        values = {getattr(point.parameters, axis) for point in figure_points}
        if len(values) < 2:
            got = f"{spec.name} with {axis} = {written(values.pop())} alone"
            allowed = f"series that feed {spec.name} and together vary {', '.join(spec.axes)}"
            if axis in spec.taken:
                allowed += f", of which it takes {axis} {spec.taken[axis]} alone"
            raise InputError.of_value(source, path, got, allowed)


def require_distinct_positions(
    spec: FigureSpec, figure_points: Sequence[Point], source: str, path: str
) -> None:
    """Raise ``InputError`` if a figure would draw two points indistinguishably at one position."""
    if not spec.draws_curves:
        return
    points_by_position: dict[tuple[Any, ...], Point] = {}
    for point in figure_points:
        other = points_by_position.setdefault(spec.place(point.parameters), point)
        if other is not point:
            raise InputError(
                f"{source}: {path}: got {spec.name} with two points at "
                f"{_settings(spec, point.parameters)} that differ in "
                f"{_differences(other.parameters, point.parameters)}{_series_note(other, point)}, "
                "which it does not show; allowed: one point at each place of a curve, the other "
                "in a series that does not feed it"
            )


def _settings(spec: FigureSpec, parameters: Parameters) -> str:
    names = dict.fromkeys((*spec.axes, *spec.curves))
    return ", ".join(f"{name} = {written(getattr(parameters, name))}" for name in names)


def _differences(first: Parameters, second: Parameters) -> str:
    """Return text with the parameters in which two points differ, and both values of each."""
    names = type(first).model_fields
    pairs = {name: (getattr(first, name), getattr(second, name)) for name in names}
    return ", ".join(
        f"{name} ({written(value)}, {written(other_value)})"
        for name, (value, other_value) in pairs.items()
        if value != other_value
    )


def _series_note(first: Point, second: Point) -> str:
    """Return text with the series of two points, empty if it is the same."""
    names = first.series[0], second.series[0]
    return f" (series {names[0]} and {names[1]})" if names[0] != names[1] else ""


def require_parameters(
    plot: PlotFile,
    axes: Sequence[str],
    system: str,
    points: Sequence[Point],
    plot_error: PlotErrorMaker,
) -> None:
    """Raise an error for a plot over parameters that do not vary, or that cannot be drawn.

    ``axes`` are the parameters on its axes.

    Raises
    ------
    InputError
        Made by ``plot_error``.
    """
    parameters = _parameters_by_key(plot, axes)
    for key, name in parameters:
        observables = SHOWN_BY[plot.base_kind](system) if key == plot.second_key else ()
        require_parameter(key, name, system, observables, plot_error)
        _require_varied(key, name, points, plot_error)
    _require_distinct(parameters, plot_error)
    _require_few_panels(plot, points, plot_error)
    _require_logarithms(plot, axes, points, plot_error)


def _parameters_by_key(plot: PlotFile, axis_names: Sequence[str]) -> list[tuple[str, str]]:
    """Return pairs of a key of the plot and the parameter that it names."""
    axes = [(key, getattr(plot, key)) for key in ("x", "y") if getattr(plot, key) in axis_names]
    curves = [
        (f"curves[{number}]" if len(plot.curves or []) > 1 else "curves", name)
        for number, name in enumerate(plot.curves or [])
    ]
    return [*axes, *curves, *([("panels", plot.panels)] if plot.panels else [])]


def _require_varied(
    key: str, name: str, points: Sequence[Point], plot_error: PlotErrorMaker
) -> None:
    values = {getattr(point.parameters, name) for point in points}
    if len(values) < 2:
        vary = varying_parameters([point.parameters for point in points])
        allowed = "a parameter that the points vary" + (f": {', '.join(vary)}" if vary else "")
        raise plot_error(key, f"{name}, which is {_value_text(values.pop())} throughout", allowed)


def _require_distinct(parameters: Sequence[tuple[str, str]], plot_error: PlotErrorMaker) -> None:
    keys: dict[str, str] = {}
    for key, name in parameters:
        if name in keys:
            raise plot_error(key, name, f"a parameter other than {keys[name]}")
        keys[name] = key


def _require_few_panels(
    plot: PlotFile, points: Sequence[Point], plot_error: PlotErrorMaker
) -> None:
    if plot.panels:
        count = len({getattr(point.parameters, plot.panels) for point in points})
        if count > MAX_PANELS:
            allowed = f"a parameter of at most {MAX_PANELS} values"
            raise plot_error("panels", f"{plot.panels} with {count} values", allowed)


def _require_logarithms(
    plot: PlotFile, axes: Sequence[str], points: Sequence[Point], plot_error: PlotErrorMaker
) -> None:
    """Raise an error for a logarithmic axis whose parameter is zero or negative at some point."""
    for number, axis in enumerate(plot.log):
        name = getattr(plot, axis)
        if name in axes:
            least = min(getattr(point.parameters, name) for point in points)
            if least <= 0:
                got = f"{axis} with {name} = {written(least)}"
                raise plot_error(
                    f"log[{number}]", got, f"an axis of values > 0, or no log of {axis}"
                )


def require_distinct_map_points(
    spec: FigureSpec, points: Sequence[Point], plot_error: PlotErrorMaker
) -> None:
    """Raise an error for a map that would draw several points at one position."""
    points_by_position: dict[tuple[Any, ...], Point] = {}
    for point in points:
        position = tuple(getattr(point.parameters, name) for name in (*spec.axes, *spec.curves))
        other = points_by_position.setdefault(position, point)
        if other is not point:
            shown = {*spec.axes, *spec.curves}
            vary = varying_parameters([other.parameters, point.parameters])
            differences = ", ".join(name for name in vary if name not in shown) or "numerics"
            allowed = f"a map with one point at each place: these differ in {differences}"
            raise plot_error("panels", spec.options["panels"] or None, allowed)


def varying_parameters(points: Sequence[Parameters]) -> list[str]:
    """Return the parameters that points of one system vary, except numerical ones."""
    return [
        name
        for name in type(points[0]).model_fields
        if name not in NUMERICAL and len({getattr(point, name) for point in points}) > 1
    ]


def _value_text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else written(value)
