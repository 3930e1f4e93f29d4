"""How the curves of a figure look and what the legend calls them, from its entry of the catalogue.

Options of a figure: ``styles``, which the paper prescribes, by the values of the parameters that
name a curve (one value, or a tuple where several name it), each colour, name of the dashes and
marker; ``entry``, the pattern of an entry in the legend, by default the settings, and ``entries``
that differ from it; ``look``, where two parameters make one entry.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from sim.figures.style import CurveStyle, cycled, literal, prescribed
from sim.parameters.words import setting
from sim.study.catalogue import FigureSpec

#: Gives style and legend entry of a curve from the values that name it and its number.
Look = Callable[[dict[str, object], int], tuple[CurveStyle, str]]


def look_of(spec: FigureSpec, keys: Sequence[str] | None = None) -> Look:
    """Return a function that gives style and legend entry of each curve of a figure.

    Parameters
    ----------
    spec : FigureSpec
        The figure.
    keys : sequence of str, optional
        Parameters that name a curve, by default its ``curves``; what else tells curves apart is
        spelled out behind them in the legend.
    """
    keys = spec.curves if keys is None else keys
    look = _LOOKS[spec.options.get("look", "values")]

    def look_and_rest(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        named = {key: names[key] for key in keys}
        style, entry = look(spec, named, index)
        rest = settings(spec.system, (item for item in names.items() if item[0] not in named))
        return style, ", ".join(filter(None, (entry, rest)))

    return look_and_rest


def settings(system: str, named: Iterable[tuple[str, object]]) -> str:
    """Write values of parameters for a legend: ``e = 0.85, K1 = 100 N/m``."""
    return literal(", ".join(setting(system, name, value) for name, value in named))


def _by_values(spec: FigureSpec, named: Mapping[str, object], index: int) -> tuple[CurveStyle, str]:
    """Return the style of the values, or else the next one, and their entry."""
    options, values = spec.options, tuple(named.values())
    styles, value = options.get("styles", {}), values[0] if len(values) == 1 else values
    style = prescribed(*styles[value]) if value in styles else cycled(index + len(styles))
    if value in (entries := options.get("entries", {})):
        return style, entries[value]
    if "entry" in options:
        return style, options["entry"].format(**named)
    return style, settings(spec.system, named.items())


def _by_amplitude_or_damping(
    spec: FigureSpec, named: Mapping[str, Any], index: int
) -> tuple[CurveStyle, str]:
    """Return a line per amplitude at the usual damping, ``markers`` alone for other dampings."""
    amplitude, damping = named["amplitude"], (named["damping"], named["shear_damping"])
    styles, markers = spec.options["styles"], spec.options["markers"]
    label = f"$A_z$ = {amplitude:g} ⟨d⟩"
    if damping == (50.0, 50.0):
        return prescribed(*styles[amplitude]) if amplitude in styles else cycled(index), label
    other = cycled(index)
    style = markers.get(damping, (other.colour, "none", other.marker))
    return prescribed(*style), pair(*damping) + ("" if amplitude == 1 else f", {label}")


def _by_damping(spec: FigureSpec, named: Mapping[str, Any], index: int) -> tuple[CurveStyle, str]:
    """Return a style per pair of damping coefficients, another for ``fast_start``."""
    damping, styles = (named["damping"], named["shear_damping"]), spec.options["styles"]
    if named.get("initial_velocity", 0):
        return prescribed(*spec.options["fast_start"]), f"{pair(*damping)}, fast start"
    style = prescribed(*styles[damping]) if damping in styles else cycled(index + len(styles))
    return style, pair(*damping)


_LOOKS = {
    "values": _by_values,
    "amplitude_or_damping": _by_amplitude_or_damping,
    "damping": _by_damping,
}


def pair(damping: float, shear_damping: float) -> str:
    """Write both damping coefficients for an entry in the legend: ``(γ, γ_s) = (0, 50g)``."""
    values = (f"{value:g}g" if value else "0" for value in (damping, shear_damping))
    return f"(γ, γ$_s$) = ({', '.join(values)})"
