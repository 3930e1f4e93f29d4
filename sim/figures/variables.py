"""What axes and colours show of every point: a parameter, an observable, or its regime.

Choices, such as contact laws and regimes, are numbered in the order of their names.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm, Normalize, to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullLocator

from sim.figures.data import FigureData, Quantity
from sim.figures.plot import (
    Panels,
    curve_keys,
    observable_label,
    observed_quantity,
    parameter_label,
    units_of_parameters,
)
from sim.figures.spheres import COLOURS as VIRIDIS
from sim.figures.style import COLOURS as NAMED_COLOURS
from sim.figures.style import (
    MEANINGS,
    CurveStyle,
    Look,
    cycle_style,
    escape_label,
    labels_and_styles,
    legend_above,
    legend_title,
    look_of,
    set_log,
    settings,
)
from sim.parameters import SYSTEMS
from sim.study.figure_spec import FigureSpec
from sim.study.plot_contents import has_logarithmic_values
from sim.study.plottable import REGIME, numbers

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

    ``label`` is that of its axis. ``values`` are not-a-number where unknown, and of a choice their
    numbers in ``choices``, which are empty for numbers. An observable has a ``quantity``.
    """

    name: str
    label: str
    values: pd.Series
    choices: tuple[str, ...] = ()
    log: bool = False
    quantity: Quantity | None = None

    def scale(self, axes: Axes, axis: str) -> None:
        """Set the scale of an axis, and the ticks of choices."""
        along = axes.xaxis if axis == "x" else axes.yaxis
        if self.log:
            set_log(axes, axis)
            return
        along.set_minor_locator(NullLocator())
        if self.choices:
            along.set_major_locator(FixedLocator(range(len(self.choices))))
            along.set_ticklabels([escape_label(name) for name in self.choices])
            getattr(axes, f"set_{axis}lim")(-0.5, len(self.choices) - 0.5)

    @property
    def norm(self) -> Normalize:
        """From values to the range of the colours."""
        values = self.values.dropna()
        if values.empty:
            return Normalize(0, 1)
        return (LogNorm if self.log else Normalize)(values.min(), values.max())

    def colours(self, values: pd.Series) -> np.ndarray:
        """Return the colours (N, 4) of values that are known."""
        if not self.choices:
            return np.asarray(SHADES(self.norm(values.to_numpy(float))))
        palette = [to_rgba(self._colour(number)) for number in range(len(self.choices))]
        return np.array([palette[int(value)] for value in values]).reshape(-1, 4)

    def _colour(self, number: int) -> str:
        named = NAMED_COLOURS[1:] + NAMED_COLOURS[:1]
        return REGIME_COLOURS.get(self.choices[number], named[number % len(named)])

    def explain_colours(self, figure: Figure, shown: Panels) -> None:
        """Put a colour bar beside panels, or an entry per choice into the legend of the first."""
        panels = [axes for axes, _ in shown]
        for number, choice in enumerate(self.choices):
            look: dict[str, Any] = {"color": self._colour(number), "linestyle": "none"}
            panels[0].plot([], [], marker="o", label=escape_label(choice), **look)
        if not self.choices:
            shades = ScalarMappable(self.norm, SHADES)
            bar = figure.colorbar(shades, ax=panels, pad=0.02, label=self.label)
            if self.log:
                set_log(bar.ax, "y")

    def text(self, value: float) -> str:
        """Write a value as ticks do."""
        return self.choices[int(value)] if self.choices else f"{value:.3g}"


def parameter(data: FigureData, name: str, *, log: bool | None = None) -> Variable:
    """Return a parameter; it is logarithmic as asked for, by default if its values are so."""
    values, units = data.rows[name], units_of_parameters(data)
    label = parameter_label(data.spec.system, name, units)
    if not is_number(data.spec.system, name):
        return _choice(name, label, values.astype(str))
    is_log = has_logarithmic_values(values) if log is None else log
    return Variable(name, label, values.astype(float), log=is_log)


def is_number(system: str, name: str) -> bool:
    """Return whether a parameter is a number, not a choice."""
    return SYSTEMS[system].model_fields[name].annotation in (int, float)


def observable(data: FigureData, option: str, axis: str) -> Variable:
    """Return the observable that an option names; 0 and less have no log."""
    shown = numbers(data.spec.system)[getattr(data.spec, option)]
    quantity = observed_quantity(data, option)
    log = axis in data.spec.log
    values = quantity.value.where(quantity.value > 0) if log else quantity.value
    label = observable_label(data, shown)
    return Variable(shown.name, label, values, log=log, quantity=quantity)


def colour(data: FigureData) -> Variable | None:
    """Return what the colours of a figure show: an observable, a parameter, regimes, or nothing."""
    name = data.spec.colour
    if name == REGIME:
        return _choice(REGIME, REGIME, data.rows["regime"])
    if name in numbers(data.spec.system):
        return observable(data, "colour", "colour")
    return parameter(data, name, log="colour" in data.spec.log) if name else None


def rows_with_values(data: FigureData, variables: Iterable[Variable]) -> pd.DataFrame:
    """Return the completed points that have a value of each variable."""
    has_value = [variable.values.notna() for variable in variables]
    return data.rows[(data.rows["completed"] > 0) & np.logical_and.reduce(has_value)]


def _choice(name: str, label: str, values: pd.Series) -> Variable:
    choices = sorted(set(values))
    numbered = values.map({value: float(number) for number, value in enumerate(choices)})
    return Variable(name, label, numbered, tuple(choices))


#: Most entries of a legend, beside those of foreign data.
MOST_ENTRIES = 10


def shared_look(data: FigureData, named: Sequence[str]) -> Look:
    """Return a look that gives a curve, identified by parameters, one style in all panels.

    Where a legend would be too long and one number tells the curves apart, their colours show it.
    """
    system = data.spec.system
    indices: dict[str, int] = {}
    keys, number = _keys(named), number_of_curves(data, named)
    curves = data.rows[keys].drop_duplicates().sort_values(keys) if keys else data.rows[:1]
    for values in curves[keys].to_dict("records"):
        indices[settings(system, values.items())] = len(indices)

    def look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
        label = settings(system, ((name, names[name]) for name in keys if name in names))
        if number is None:
            return cycle_style(indices.get(label, index)), label
        (shade,) = number.colours(pd.Series([names[number.name]]))
        return CurveStyle(to_hex(shade), "-"), label

    return look


def number_of_curves(data: FigureData, named: Sequence[str]) -> Variable | None:
    """Return the number that alone tells more curves apart than a legend has entries, if any.

    ``named`` are the parameters that identify curves.
    """
    varied = [name for name in _keys(named) if data.rows[name].nunique() > 1]
    if len(varied) != 1 or not is_number(data.spec.system, varied[0]):
        return None
    is_long = data.rows[varied[0]].nunique() > MOST_ENTRIES
    return parameter(data, varied[0]) if is_long else None


def _keys(named: Sequence[str]) -> list[str]:
    return [name for name in named if name != "protocol"]


def legend(
    data: FigureData,
    figure: Figure,
    shown: Panels,
    named: Sequence[str] = (),
    foreign: Mapping[str, Any] | None = None,
) -> None:
    """Put one legend above all panels, with each label once; none where no curve has a label.

    Of more curves than `MOST_ENTRIES`, it only gives their number, or a colour bar shows the number
    that tells them apart. ``named`` are the parameters that identify curves; the title says what
    their symbols mean. ``foreign`` are entries of foreign data, which may equal those of curves.
    """
    entries: dict[str, Any] = {}
    for axes, _ in shown:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    entries.pop("", None)
    marks = [(label, entries.pop(label)) for label in MEANINGS if label in entries]
    spec = data.spec
    is_named = is_prescribed(spec) or bool(spec.quantities or spec.show == REGIME)
    if not is_named and (number := number_of_curves(data, named)) is not None:
        number.explain_colours(figure, shown)
        entries = {}
    if len(entries) > MOST_ENTRIES and not is_named:
        entries = {f"{len(entries):,} curves, which the data names": Line2D([], [], linestyle="")}
    pairs = [*entries.items(), *marks, *(foreign or {}).items()]
    if pairs:
        varied = [name for name in _keys(named) if data.rows[name].nunique() > 1]
        title = legend_title(data.spec.system, varied) if entries else ""
        labels, handles = zip(*pairs, strict=True)
        legend_above(figure, handles, labels, title)


def groups(
    data: FigureData, rows: pd.DataFrame
) -> Iterator[tuple[CurveStyle, str, Mapping[str, Any]]]:
    """Yield style, legend entry and row of each completed point: each is one curve."""
    keys = curve_keys(data)
    completed = rows[rows["completed"] > 0]
    records = (completed.sort_values(list(keys)) if keys else completed).to_dict("records")
    names = [{str(name): row[name] for name in keys} for row in records]
    if is_prescribed(data.spec):
        labels, styles = labels_and_styles(names, look_of(data.spec, data.spec.by))
        looks = [(styles[label], label) for label in labels]
    else:
        look = shared_look(data, keys)
        looks = [look(one, index) for index, one in enumerate(names)]
    for (style, label), row in zip(looks, records, strict=True):
        yield style, label, {str(name): value for name, value in row.items()}


def is_prescribed(spec: FigureSpec) -> bool:
    """Return whether a figure says itself what its curves look like."""
    return bool(spec.styles or spec.entry)
