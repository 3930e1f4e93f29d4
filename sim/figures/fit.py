"""Laws that are fitted to curves, with errors of their numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from sim.base.statistics import student
from sim.figures.data import FigureData, Quantity, split_curves
from sim.figures.style import Look
from sim.parameters.words import setting

#: Class of a law in `lmfit.models`, its formula, and its numbers there by their letters.
LAWS: dict[str, tuple[str, str, dict[str, str]]] = {
    "linear": ("LinearModel", "y = a + b x", {"a": "intercept", "b": "slope"}),
    "quadratic": ("QuadraticModel", "y = a + b x + c x²", {"a": "c", "b": "b", "c": "a"}),
    "power": ("PowerLawModel", "y = a xᵇ", {"a": "amplitude", "b": "exponent"}),
    "exponential": ("ExponentialModel", "y = a exp(-x/b)", {"a": "amplitude", "b": "decay"}),
}

#: Most curves whose numbers a caption gives.
MOST_IN_CAPTION = 8

#: Standard errors in the half width of a 95 % interval, where the error is known.
_NORMAL = 1.96

#: Points of the line of a law.
_STEPS = 200


@dataclass(frozen=True)
class Fit:
    """A law that was fitted to one curve.

    ``names`` are the parameters that tell the curve apart, ``rows`` those of its points.
    ``problem`` is why there is no fit, else empty. ``numbers`` are value and half width of the 95 %
    interval of each number of the law, by its letter, and ``line`` is the law over the range of the
    points, by x. ``weighted`` points have weights from their intervals.
    """

    names: Mapping[str, Any]
    rows: pd.Index
    problem: str = ""
    numbers: dict[str, tuple[float, float]] = field(default_factory=dict)
    line: pd.Series = field(default_factory=lambda: pd.Series(dtype=float))
    weighted: bool = False


def fit_curves(
    law: str, points: pd.DataFrame, quantity: Quantity, along: str, keys: Sequence[str]
) -> list[Fit]:
    """Fit one of `LAWS` to the quantity of each curve along a column.

    ``keys`` tell curves apart. Flows that accelerate are left out.
    """
    value, half = quantity.value, quantity.half_width
    return [
        _fit(law, names, curve[along], value[curve.index], half[curve.index])
        for names, every in split_curves(points, along, keys, ())
        for curve in [every[every["regime"] != "accelerating"]]
    ]


def fit_places(law: str, names: Mapping[str, Any], x: pd.Series, y: pd.Series) -> Fit:
    """Fit one of `LAWS` to places in a plane, with equal weights."""
    return _fit(law, names, x, y, pd.Series(np.nan, x.index))


def _fit(law: str, names: Mapping[str, Any], x: pd.Series, y: pd.Series, half: pd.Series) -> Fit:
    """Fit a law to the points (x, y) of a curve, by least squares.

    Weights are 1/error², from the intervals if all points have one. The intervals of the numbers
    are the larger of those that follow from these errors and from the scatter about the line.
    """
    # Imported here: it takes half a second, and few plots have a fit.
    from lmfit import models

    model_name, _, letters = LAWS[law]
    freedom = len(x) - len(letters)
    if x.nunique() <= len(letters):
        count = f"{x.nunique()} value{'s' * (x.nunique() != 1)} of x"
        return Fit(names, x.index, f"{count} where {len(letters) + 1} are needed")
    if law == "power" and ((x <= 0) | (y <= 0)).any():
        return Fit(names, x.index, "some values are not above 0")
    errors = half / _NORMAL
    weighted = bool((errors > 0).all())
    model = getattr(models, model_name)()
    try:
        result = model.fit(
            y.to_numpy(),
            model.guess(y.to_numpy(), x=x.to_numpy()),
            x=x.to_numpy(),
            weights=1 / errors.to_numpy() if weighted else None,
            scale_covar=False,
        )
    except (ValueError, TypeError):
        return Fit(names, x.index, "it did not converge")
    if not (result.success and result.errorbars):
        return Fit(names, x.index, "it did not converge")
    scale = max(student(freedom) * np.sqrt(result.redchi), _NORMAL if weighted else 0.0)
    values = {
        letter: (float(result.params[name].value), float(scale * result.params[name].stderr))
        for letter, name in letters.items()
    }
    ends = np.geomspace if x.min() > 0 else np.linspace
    at = ends(x.min(), x.max(), _STEPS)
    line = pd.Series(np.asarray(result.eval(x=at), float), at)
    return Fit(names, x.index, "", values, line, weighted)


def draw_fits(axes: Axes, fits: Sequence[Fit], look: Look) -> None:
    """Draw the lines of fits in the colours of their curves."""
    for index, fit in enumerate(fits):
        names = {name: value for name, value in fit.names.items() if name != "protocol"}
        style, _ = look(names, index)
        axes.plot(fit.line.index, fit.line, color=style.colour, linewidth=1.2, zorder=2)


def fit_notes(data: FigureData, fits: Sequence[Fit], basis: str = "") -> list[str]:
    """Return the sentences of the caption on fitted lines; empty without any.

    ``basis`` is what they are fitted to, where that is not the points of curves.
    """
    if not fits:
        return []
    law = f"{data.spec.fit} law {LAWS[data.spec.fit][1]}"
    weights = "with equal weights where points have no interval"
    if all(fit.weighted or fit.problem for fit in fits):
        weights = "weighted by the intervals"
    numbers = "; ".join(_fit_text(data, fit) for fit in fits)
    if len(fits) > MOST_IN_CAPTION:
        numbers = f"the numbers of {len(fits)} curves are in the data"
    basis = basis or f"{weights}; flows that accelerate are left out"
    return [
        f"Lines: {law}, least squares in the units of the axes, {basis}; ± half width of the 95 % "
        f"interval: {numbers}."
    ]


def _fit_text(data: FigureData, fit: Fit) -> str:
    """Return the numbers of a fit, or why there is none, with what tells the curve apart."""
    label = ", ".join(setting(data.spec.system, *item) for item in fit.names.items())
    text = ", ".join(
        f"{key} = {value:.4g} ± {half:.2g}" for key, (value, half) in fit.numbers.items()
    )
    return " ".join(filter(None, (label and f"{label}:", text or f"no fit, as {fit.problem}")))


def fit_columns(data: FigureData, fits: Sequence[Fit]) -> dict[str, pd.Series]:
    """Return the numbers of the fit of each point's curve, by headings; empty without any."""
    columns: dict[str, pd.Series] = {}
    for fit in fits:
        for key, numbers in fit.numbers.items():
            headings = f"{key} of the fit", f"half width of 95 % interval of {key}"
            for heading, number in zip(headings, numbers, strict=True):
                columns.setdefault(heading, pd.Series(np.nan, data.rows.index))[fit.rows] = number
    return columns
