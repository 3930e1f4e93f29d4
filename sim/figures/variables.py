"""What axes and colours show of every point: a parameter, an observable, or its regime.

Choices, such as contact laws and regimes, are numbered in the order of their names.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm, Normalize, to_rgba
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullLocator

from sim.figures.axes import set_log
from sim.figures.configuration import COLOURS as VIRIDIS
from sim.figures.data import FigureData
from sim.figures.plot import observable_label, observed_quantity, parameter_label
from sim.figures.quantity import Quantity
from sim.figures.style import COLOURS as NAMED_COLOURS
from sim.figures.style import escape_label
from sim.parameters import SYSTEMS
from sim.study.plot_kinds import REGIME
from sim.study.plottable import numbers

#: Ratio of the ends of a parameter from which its axis may be logarithmic.
_WIDE = 8.0

#: Most ticks of an axis in a small panel, and the ratio of its ends from which they are at powers
#: of ten alone.
_FEW, _DECADES = 4, 30

#: Colours of numbers; the palest are left out, as points lie on white, or on black once inverted.
SHADES = ListedColormap(VIRIDIS(np.linspace(0, 0.87, 256)))

#: Colours of regimes.
REGIME_COLOURS = {
    "steady": "#0072b2",
    "accelerating": "#d55e00",
    "arrested": "#000000",
    "mixed": "#cc79a7",
    "undetermined": "#888888",
}


@dataclass(frozen=True)
class Variable:
    """A parameter, an observable or the regime of all points of a figure.

    Attributes
    ----------
    name, label : str
        Its name, and the label of its axis with the unit.
    values : pandas.Series
        Its values; of a choice their numbers in ``choices``. Not-a-number where unknown.
    choices : tuple of str
        The values of a choice; empty for numbers.
    log : bool
        Whether its axis is logarithmic.
    """

    name: str
    label: str
    values: pd.Series
    choices: tuple[str, ...] = ()
    log: bool = False

    def scale(self, axes: Axes, axis: str, ticks: int) -> None:
        """Set the scale of an axis and at most so many ticks."""
        along = axes.xaxis if axis == "x" else axes.yaxis
        if self.log:
            set_log(axes, axis)
            if ticks <= _FEW:
                is_wide = self.values.max() > _DECADES * self.values.min()
                along.set_major_locator(LogLocator(subs=(1,) if is_wide else (1, 2, 5)))
                along.set_minor_locator(NullLocator())
            return
        along.set_minor_locator(NullLocator())
        if self.choices:
            along.set_major_locator(FixedLocator(range(len(self.choices))))
            along.set_ticklabels([escape_label(name) for name in self.choices])
            getattr(axes, f"set_{axis}lim")(-0.5, len(self.choices) - 0.5)
        else:
            along.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 2.5, 5, 10]))

    def text(self, value: float) -> str:
        """Write a value as ticks do."""
        return self.choices[int(value)] if self.choices else f"{value:.3g}"


def parameter(data: FigureData, name: str, *, log: bool | None = None) -> Variable:
    """Return a parameter; it is logarithmic as asked for, by default if its values are so."""
    values, label = data.rows[name], parameter_label(data.spec.system, name)
    if not is_number(data.spec.system, name):
        return _choice(name, label, values.astype(str))
    is_log = has_logarithmic_values(values) if log is None else log
    return Variable(name, label, values.astype(float), log=is_log)


def is_number(system: str, name: str) -> bool:
    """Return whether a parameter is a number, not a choice."""
    return SYSTEMS[system].model_fields[name].annotation in (int, float)


def parameters(data: FigureData) -> list[Variable]:
    """Return the parameters on the axes of a figure that shows several."""
    return [parameter(data, name) for name in data.spec.axes]


def observable(data: FigureData, option: str, axis: str) -> tuple[Variable, Quantity]:
    """Return the observable that an option names, and its intervals; 0 and less have no log."""
    shown = numbers(data.spec.system)[data.spec.options[option]]
    quantity = observed_quantity(data, option)
    log = axis in data.spec.options["log"]
    values = quantity.value.where(quantity.value > 0) if log else quantity.value
    return Variable(shown.name, observable_label(data, shown), values, log=log), quantity


def colour(data: FigureData) -> Variable | None:
    """Return what the colours of a figure show: an observable, a parameter, regimes, or nothing."""
    name = data.spec.options["colour"]
    if name == REGIME:
        return _choice(REGIME, REGIME, data.rows["regime"])
    if name in numbers(data.spec.system):
        return observable(data, "colour", "colour")[0]
    return parameter(data, name, log="colour" in data.spec.options["log"]) if name else None


def known_rows(data: FigureData, variables: Iterable[Variable]) -> pd.DataFrame:
    """Return the completed points that have a value of each variable."""
    known = [variable.values.notna() for variable in variables]
    return data.rows[(data.rows["completed"] > 0) & np.logical_and.reduce(known)]


def _choice(name: str, label: str, values: pd.Series) -> Variable:
    choices = sorted(set(values))
    numbered = values.map({value: float(number) for number, value in enumerate(choices)})
    return Variable(name, label, numbered, tuple(choices))


def has_logarithmic_values(values: pd.Series) -> bool:
    """Return whether values spread over a wide range evenly in their logarithm."""
    low, middle, high = values.min(), values.median(), values.max()
    if low <= 0 or high < _WIDE * low:
        return False
    geometric, arithmetic = np.sqrt(low * high), (low + high) / 2
    return bool(abs(np.log(middle / geometric)) < abs(np.log(middle / arithmetic)))


@dataclass(frozen=True)
class Colours:
    """The colours of a variable, and what explains them: a colour bar, or entries of a legend."""

    variable: Variable

    @property
    def norm(self) -> Normalize:
        """From values to the range of the colours."""
        known = self.variable.values.dropna()
        if known.empty:
            return Normalize(0, 1)
        return (LogNorm if self.variable.log else Normalize)(known.min(), known.max())

    def of(self, values: pd.Series) -> np.ndarray:
        """Return the colours (N, 4) of values that are known."""
        if not self.variable.choices:
            return np.asarray(SHADES(self.norm(values.to_numpy(float))))
        palette = [to_rgba(self._named(number)) for number in range(len(self.variable.choices))]
        return np.array([palette[int(value)] for value in values]).reshape(-1, 4)

    def _named(self, number: int) -> str:
        named = NAMED_COLOURS[1:] + NAMED_COLOURS[:1]
        return REGIME_COLOURS.get(self.variable.choices[number], named[number % len(named)])

    def explain(self, figure: Figure, axes: list[Axes], **options: Any) -> None:
        """Put a colour bar beside axes, or an entry per choice into the legend of the first.

        ``options`` are those of `matplotlib.figure.Figure.colorbar`.
        """
        if self.variable.choices:
            for number, choice in enumerate(self.variable.choices):
                look: dict[str, Any] = {"color": self._named(number), "linestyle": "none"}
                axes[0].plot([], [], marker="o", label=escape_label(choice), **look)
            return
        bar = figure.colorbar(ScalarMappable(self.norm, SHADES), ax=axes, pad=0.02, **options)
        bar.set_label(self.variable.label)
        bar.outline.set_visible(False)
        if self.variable.log:
            set_log(bar.ax, "y")
