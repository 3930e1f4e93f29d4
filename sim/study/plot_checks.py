"""What is refused of plots whose keys are right: parameters that the points do not bear out."""

from collections.abc import Callable, Collection, Sequence
from typing import Any

from sim.base.errors import InputError
from sim.base.messages import did_you_mean
from sim.parameters import NUMERICAL, SYSTEMS, Parameters
from sim.study.catalogue import FigureSpec
from sim.study.catalogue.spec import written
from sim.study.model import Point
from sim.study.plot_file import PlotFile
from sim.study.plottable import SHOWN_BY

#: Most panels of a plot.
MOST_PANELS = 12

#: Gives the error of a key of the plot, its value, and what is allowed.
Refused = Callable[[str, Any, str], InputError]


def require_parameters(
    one: PlotFile, axes: Sequence[str], system: str, points: Sequence[Point], refused: Refused
) -> None:
    """Refuse a plot over what the points of its system do not vary, or that cannot be drawn.

    ``axes`` are those of its parameters that stand on axes.

    Raises
    ------
    InputError
        That ``refused`` gives.
    """
    named = _parameters(one, axes)
    for key, name in named:
        either = SHOWN_BY[one.like](system) if key == one.second else ()
        _require_parameter(key, name, system, either, refused)
        _require_varied(key, name, points, refused)
    _require_distinct(named, refused)
    _require_few_panels(one, points, refused)
    _require_logarithms(one, axes, points, refused)


def _parameters(one: PlotFile, on_axes: Sequence[str]) -> list[tuple[str, str]]:
    """Return the parameters that a plot is over, with the keys that name them."""
    axes = [(key, getattr(one, key)) for key in ("x", "y") if getattr(one, key) in on_axes]
    curves = [
        (f"curves[{number}]" if len(one.curves or []) > 1 else "curves", name)
        for number, name in enumerate(one.curves or [])
    ]
    return [*axes, *curves, *([("panels", one.panels)] if one.panels else [])]


def _require_parameter(
    key: str, name: str, system: str, either: Collection[str], refused: Refused
) -> None:
    """Refuse what is no parameter of the system, or on an axis no number.

    ``either`` are the observables that may stand in its place.
    """
    fields = SYSTEMS[system].model_fields
    if name not in fields or name == "system":
        others = [one for one, model in SYSTEMS.items() if name in model.model_fields]
        if name != "system" and others:
            raise refused(key, name, f"a parameter of the {system}; this is one of the {others[0]}")
        known = [one for one in fields if one != "system"]
        hint, other = did_you_mean(name, [*known, *either]), ", or an observable" if either else ""
        raise refused(key, name, f"{hint}a parameter of the {system} that the points vary{other}")
    if key in ("x", "y") and fields[name].annotation not in (int, float):
        raise refused(key, name, "a parameter that is a number; curves and panels take any")


def _require_varied(key: str, name: str, points: Sequence[Point], refused: Refused) -> None:
    values = {getattr(point.parameters, name) for point in points}
    if len(values) < 2:
        vary = varying_of([point.parameters for point in points])
        allowed = "a parameter that the points vary" + (f": {', '.join(vary)}" if vary else "")
        raise refused(key, f"{name}, which is {_written(values.pop())} throughout", allowed)


def _require_distinct(named: Sequence[tuple[str, str]], refused: Refused) -> None:
    seen: dict[str, str] = {}
    for key, name in named:
        if name in seen:
            raise refused(key, name, f"a parameter other than {seen[name]}")
        seen[name] = key


def _require_few_panels(one: PlotFile, points: Sequence[Point], refused: Refused) -> None:
    if one.panels:
        count = len({getattr(point.parameters, one.panels) for point in points})
        if count > MOST_PANELS:
            allowed = f"a parameter of at most {MOST_PANELS} values"
            raise refused("panels", f"{one.panels} with {count} values", allowed)


def _require_logarithms(
    one: PlotFile, axes: Sequence[str], points: Sequence[Point], refused: Refused
) -> None:
    """Refuse a logarithmic axis of a parameter that is zero or negative somewhere."""
    for number, axis in enumerate(one.log):
        name = getattr(one, axis)
        if name in axes:
            least = min(getattr(point.parameters, name) for point in points)
            if least <= 0:
                got = f"{axis} with {name} = {written(least)}"
                raise refused(f"log[{number}]", got, f"an axis of values > 0, or no log of {axis}")


def require_nothing_else(spec: FigureSpec, points: Sequence[Point], refused: Refused) -> None:
    """Refuse a map on which several points would lie on each other."""
    places: dict[tuple[Any, ...], Point] = {}
    for point in points:
        place = tuple(getattr(point.parameters, name) for name in (*spec.axes, *spec.curves))
        other = places.setdefault(place, point)
        if other is not point:
            shown = {*spec.axes, *spec.curves}
            vary = varying_of([other.parameters, point.parameters])
            differ = ", ".join(name for name in vary if name not in shown)
            allowed = f"a map with one point at each place: these differ in {differ or 'numerics'}"
            raise refused("panels", spec.options["panels"] or None, allowed)


def varying_of(points: Sequence[Parameters]) -> list[str]:
    """Return the parameters that some points of one system vary, those that count as physics."""
    return [
        name
        for name in type(points[0]).model_fields
        if name not in NUMERICAL and len({getattr(point, name) for point in points}) > 1
    ]


def _written(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else written(value)
