"""Laws that are fitted to curves, with errors of their numbers."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from sim.base.additions import additions
from sim.base.errors import count_text
from sim.base.statistics import student
from sim.figures.data import FigureData, Quantity, split_curves
from sim.figures.style import Look
from sim.parameters.words import setting
from sim.study.plot_file import FIT, FitLaw


@dataclass(frozen=True)
class Law:
    """A law: its ``formula``, and its numbers by letter, as ``letters`` or names in the model.

    ``function`` gives it from x and its numbers, or names a class in `lmfit.models`. ``start`` are
    the first values of the numbers, or a function of x and y that returns them; ``within`` are
    bounds of a number as a function of x. What is ``positive`` has to be above 0.
    """

    formula: str
    letters: Mapping[str, str]
    function: str | Callable[..., Any]
    start: Callable[[np.ndarray, np.ndarray], Mapping[str, float]] | None = None
    within: Mapping[str, Callable[[np.ndarray], tuple[float, float]]] = field(default_factory=dict)
    positive: str = ""


def _stop_height(x: Any, θ1: float, θ2: float, B: float) -> Any:  # noqa: N803
    steep, flat, slope = (np.tan(np.radians(one)) for one in (θ2, θ1, x))
    return B * (steep - slope) / (slope - flat)


def _start_of_heights(x: np.ndarray, y: np.ndarray) -> dict[str, float]:
    """Return first values of Pouliquen's law: for each tan θ1 it is linear in B tan θ2 and B."""
    slope = np.tan(np.radians(x))
    span = np.ptp(slope)

    def columns(flat: float) -> np.ndarray:
        return np.column_stack([1.0 / (slope - flat), -slope / (slope - flat)])

    flats = slope.min() - span * np.geomspace(1e-3, 3.0, _TRIALS)
    flat, (steep, factor) = _best(flats[flats > 0], columns, y)
    angles = np.degrees(np.arctan([flat, steep / factor]))
    return {"θ1": float(angles[0]), "θ2": float(angles[1]), "B": factor}


def _friction(x: Any, μ1: float, μ2: float, I0: float) -> Any:  # noqa: N803
    return μ1 + (μ2 - μ1) * x / (I0 + x)


def _start_of_friction(x: np.ndarray, y: np.ndarray) -> dict[str, float]:
    """Return first values of μ(I): for each I0 it is linear in μ1 and μ2 - μ1."""

    def columns(number: float) -> np.ndarray:
        return np.column_stack([np.ones_like(x), x / (number + x)])

    number, (low, rise) = _best(np.geomspace(0.03 * x.min(), 30 * x.max(), _TRIALS), columns, y)
    return {"μ1": low, "μ2": low + rise, "I0": number}


def _best(
    trials: np.ndarray, columns: Callable[[float], np.ndarray], y: np.ndarray
) -> tuple[float, list[float]]:
    """Return the trial value with the least squares, and the factors of its columns."""
    fitted = [(one, np.linalg.lstsq(columns(one), y, rcond=None)[0]) for one in trials.tolist()]
    best, factors = min(fitted, key=lambda one: float(((columns(one[0]) @ one[1] - y) ** 2).sum()))
    return best, factors.tolist()


#: Values of a number that are tried for the first of a law.
_TRIALS = 60

#: The laws that ship. Pouliquen, Phys. Fluids 11 (1999) 542; Jop, Forterre and Pouliquen, Nature
#: 441 (2006) 727.
LAWS: dict[str, Law] = {
    "linear": Law("y = a + b x", {"a": "intercept", "b": "slope"}, "LinearModel"),
    "quadratic": Law("y = a + b x + c x²", {"a": "c", "b": "b", "c": "a"}, "QuadraticModel"),
    "power": Law("y = a xᵇ", {"a": "amplitude", "b": "exponent"}, "PowerLawModel", positive="x y"),
    "exponential": Law("y = a exp(-x/b)", {"a": "amplitude", "b": "decay"}, "ExponentialModel"),
    "pouliquen": Law(
        "y = B (tan θ2 - tan x)/(tan x - tan θ1)",
        {one: one for one in ("θ1", "θ2", "B")},
        _stop_height,
        _start_of_heights,
        {"θ1": lambda x: (0.0, float(x.min())), "B": lambda x: (0.0, np.inf)},
        positive="x y",
    ),
    "mu_of_i": Law(
        "y = μ1 + (μ2 - μ1)/(I0/x + 1)",
        {one: one for one in ("μ1", "μ2", "I0")},
        _friction,
        _start_of_friction,
        {"I0": lambda x: (0.0, np.inf)},
        positive="x",
    ),
}


def law_of(name: str) -> Law:
    """Return a law by its name in study files, of Talus or of a plug-in."""
    if name in LAWS:
        return LAWS[name]
    own: FitLaw = additions(FIT)[name].value
    return Law(own.formula, {one: one for one in own.start}, own.function, lambda x, y: own.start)


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
    """Fit a law, by its name, to the quantity of each curve along a column.

    ``keys`` tell curves apart. Flows that accelerate are left out.
    """
    value, half = quantity.value, quantity.half_width
    return [
        fit_points(law, names, curve[along], value[curve.index], half[curve.index])
        for names, every in split_curves(points, along, keys, ())
        for curve in [every[every["regime"] != "accelerating"]]
    ]


def fit_points(
    law: str, names: Mapping[str, Any], x: pd.Series, y: pd.Series, half: pd.Series | None = None
) -> Fit:
    """Fit a law, by its name, to points (x, y), by least squares.

    Weights are 1/error², from the intervals if all points have one. The intervals of the numbers
    are the larger of those that follow from these errors and from the scatter about the line.
    """
    fitted, index = law_of(law), x.index
    letters, freedom = fitted.letters, len(x) - len(fitted.letters)
    if x.nunique() <= len(letters):
        count = count_text(x.nunique(), "value")
        return Fit(names, index, f"{count} of x where {len(letters) + 1} are needed")
    values = {"x": x.to_numpy(), "y": y.to_numpy()}
    if any((values[axis] <= 0).any() for axis in fitted.positive.split()):
        return Fit(names, index, "some values are not above 0")
    weighted = half is not None and bool((half > 0).all())
    weights = 1 / (half.to_numpy() / _NORMAL) if half is not None and weighted else None
    try:
        model, start = _begun(fitted, **values)
        result = model.fit(values["y"], start, x=values["x"], weights=weights, scale_covar=False)
    except (ValueError, TypeError):
        result = None
    if not (result and result.success and result.errorbars):
        return Fit(names, index, "it did not converge")
    scale = max(student(freedom) * np.sqrt(result.redchi), _NORMAL if weighted else 0.0)
    numbers = {
        letter: (float(result.params[name].value), float(scale * result.params[name].stderr))
        for letter, name in letters.items()
    }
    ends = np.geomspace if x.min() > 0 else np.linspace
    at = ends(x.min(), x.max(), _STEPS)
    line = pd.Series(np.asarray(result.eval(x=at), float), at)
    return Fit(names, index, "", numbers, line, weighted)


def _begun(law: Law, x: np.ndarray, y: np.ndarray) -> tuple[Any, Any]:
    """Return the model of a law in lmfit, which is on `scipy.optimize`, and its first values."""
    # Imported here: it takes half a second, and few plots have a fit.
    from lmfit import Model, models

    if isinstance(law.function, str):
        model = getattr(models, law.function)()
        return model, model.guess(y, x=x)
    model = Model(law.function, independent_vars=["x"], param_names=[*law.letters])
    start = model.make_params(**(law.start(x, y) if law.start else {}))
    for name, bounds in law.within.items():
        low, high = bounds(x)
        start[name].set(min=low, max=high)
    return model, start


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
    law = f"{data.spec.fit} law {law_of(data.spec.fit).formula}"
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
