"""Styles and legend entries of the curves of a figure, from its entry of the catalogue.

Options of a figure: ``styles`` are those that the paper prescribes, by the values of the parameters
that name a curve (one value, or a tuple of several): colour, dashes, marker and, where it is no
other's, the legend entry. ``entry`` is the pattern of the other entries, by default the settings.
With ``look: damping`` two parameters make one entry.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sim.figures.style import PATTERNS, CurveStyle, cycle_style, escape_label, prescribed_style
from sim.parameters.words import setting
from sim.study.figure_spec import FigureSpec

#: Returns style and legend entry of a curve from the values that name it and its index.
Look = Callable[[dict[str, object], int], tuple[CurveStyle, str]]


def look_of(spec: FigureSpec, keys: Sequence[str] | None = None) -> Look:
    """Return a function that returns style and legend entry of each curve of a figure.

    Parameters
    ----------
    spec : FigureSpec
        The figure.
    keys : sequence of str, optional
        Parameters that name a curve, by default the ``curves`` of the figure. The legend entry ends
        with the settings of all other parameters that distinguish curves.
    """
    keys = spec.curves if keys is None else keys
    look = _by_damping if spec.options.get("look") == "damping" else _by_values

    def look_and_rest(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        key_values = {key: names[key] for key in keys}
        style, entry = look(spec, key_values, index)
        rest = settings(spec.system, (item for item in names.items() if item[0] not in key_values))
        return style, ", ".join(filter(None, (entry, rest)))

    return look_and_rest


def look_of_measure(spec: FigureSpec, keys: Sequence[str], option: Mapping[str, Any]) -> Look:
    """Return the look of the curves of one of several measures.

    ``option`` is the measure: its ``entry`` follows the settings, and it has a style of its own, or
    ``dashes`` alone instead of those of the curve.
    """
    look = look_of(spec, keys)

    def look_of_curve(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        style, entry = look(names, index)
        if "colour" in option:
            style = prescribed_style(option)
        elif "dashes" in option:
            style = replace(style, dashes=PATTERNS[option["dashes"]])
        return style, ", ".join(filter(None, (entry, option.get("entry"))))

    return look_of_curve


def settings(system: str, values: Iterable[tuple[str, object]]) -> str:
    """Write values of parameters for a legend: ``e = 0.85, K1 = 100 N/m``."""
    return escape_label(", ".join(setting(system, name, value) for name, value in values))


def _by_values(
    spec: FigureSpec, key_values: Mapping[str, object], index: int
) -> tuple[CurveStyle, str]:
    """Return the prescribed style of the values, or else the next one, and their legend entry."""
    options, values = spec.options, tuple(key_values.values())
    styles, value = options.get("styles", {}), values[0] if len(values) == 1 else values
    style = prescribed_style(styles[value]) if value in styles else cycle_style(index + len(styles))
    if entry := styles.get(value, {}).get("entry"):
        return style, entry
    if "entry" in options:
        return style, options["entry"].format(**key_values)
    return style, settings(spec.system, key_values.items())


def _by_damping(
    spec: FigureSpec, key_values: Mapping[str, Any], index: int
) -> tuple[CurveStyle, str]:
    """Return a style per pair of damping coefficients, and a separate one for ``fast_start``."""
    damping, styles = (key_values["damping"], key_values["shear_damping"]), spec.options["styles"]
    if key_values.get("initial_velocity", 0):
        return prescribed_style(styles["fast_start"]), f"{pair(*damping)}, fast start"
    style = (
        prescribed_style(styles[damping]) if damping in styles else cycle_style(index + len(styles))
    )
    return style, pair(*damping)


def pair(damping: float, shear_damping: float) -> str:
    """Write both damping coefficients for an entry in the legend: ``(γ, γ_s) = (0, 50g)``."""
    values = (f"{value:g}g" if value else "0" for value in (damping, shear_damping))
    return f"(γ, γ$_s$) = ({', '.join(values)})"
