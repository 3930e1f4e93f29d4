"""What Gallas' Figs. 2 and 3 share: a profile over the height above the belt, a curve per flow."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.dataset.replicates import student_half_width
from sim.figures import transport
from sim.figures.caption import counted, points_text
from sim.figures.columns import parameter_columns
from sim.figures.family import Look
from sim.figures.style import (
    BESIDE,
    DASH_DOT,
    DOTTED,
    LONG_DASH,
    SHORT_DASH,
    CurveStyle,
    canvas,
    cycled,
    name_protocols,
    place_legend,
)
from sim.figures.summary import FigureData, split_curves
from sim.figures.transport import describe, pair
from sim.parameters import BeltParameters

#: Parameters that the captions of all six panels give.
NAMED = ("frequency", *transport.NAMED)

#: Number density (1/⟨d⟩²) of the emptiest slice at the top of a profile.
THIN = 0.01


class Quantity(NamedTuple):
    """A profile: name in the dataset, label of the axis, heading of the data, factor ⟨d⟩^power."""

    name: str
    label: str
    heading: str
    power: int


DENSITY = Quantity("number_density", "number density ρ (1/⟨d⟩²)", "number density [⟨d⟩-2]", 2)
VELOCITY = Quantity("velocity_profile", "mean velocity $v_x$ (m/s)", "mean velocity [m s-1]", 0)

_FREQUENCIES = {
    10.0: CurveStyle("#000000", "-"),
    20.0: CurveStyle("#0072b2", LONG_DASH),
    60.0: CurveStyle("#d55e00", DASH_DOT),
    80.0: CurveStyle("#009e73", DOTTED),
}
_ANGLES = {
    90.0: (CurveStyle("#009e73", DOTTED), "α = π/2"),
    60.0: (CurveStyle("#d55e00", DASH_DOT), "α = π/3"),
    45.0: (CurveStyle("#000000", "-"), "α = π/4"),
    30.0: (CurveStyle("#0072b2", SHORT_DASH), "α = π/6"),
}
_DAMPINGS = {
    (10.0, 10.0): CurveStyle("#0072b2", SHORT_DASH),
    (0.0, 50.0): CurveStyle("#d55e00", DASH_DOT),
    (50.0, 100.0): CurveStyle("#000000", "-"),
}

_FAST_START = CurveStyle("#009e73", LONG_DASH)


def by_frequency(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    """Return style and legend entry of a flow in Figs. 2a and 3a."""
    frequency = names["frequency"]
    return _FREQUENCIES.get(frequency, cycled(index + len(_FREQUENCIES))), f"f = {frequency:g} Hz"


def by_angle(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    """Return style and legend entry of a flow in Figs. 2b and 3b."""
    angle = names["vibration_angle"]
    return _ANGLES.get(angle, (cycled(index + len(_ANGLES)), f"α = {angle:g}°"))


def by_damping(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    """Return style and legend entry of a flow in Figs. 2c and 3c; fast starts are dashed."""
    damping, shear_damping = names["damping"], names["shear_damping"]
    style = _DAMPINGS.get((damping, shear_damping), cycled(index + len(_DAMPINGS)))
    label = pair(damping, shear_damping)
    if not names.get("initial_velocity", 0):
        return style, label
    return _FAST_START, f"{label}, fast start"


class Panel(NamedTuple):
    """What the module of a panel offers: functions of its `FigureData`."""

    draw: Callable[[FigureData], Figure]
    table: Callable[[FigureData], pd.DataFrame]
    notes: Callable[[FigureData], list[str]]


def panel(quantity: Quantity, keys: Sequence[str], look: Look) -> Panel:
    """Return how a panel is drawn, what its table holds and what its caption says.

    Arguments as for `draw_panel`.
    """
    return Panel(
        partial(draw_panel, quantity=quantity, keys=keys, look=look),
        partial(table, quantity=quantity),
        partial(notes, quantity=quantity),
    )


def draw_panel(data: FigureData, quantity: Quantity, keys: Sequence[str], look: Look) -> Figure:
    """Draw one profile of every flow.

    Parameters
    ----------
    data : FigureData
        Points and the dataset they are from.
    quantity : Quantity
        What is drawn over the height above the belt.
    keys : sequence of str
        Parameters that name a flow.
    look : callable
        Gives style and legend entry from the values of the keys and the number of the flow.
    """
    figure, axes = canvas()
    table = profiles(data, quantity)
    shown = data.rows[data.rows["completed"] > 0]
    beside = shown["protocol"].nunique() > 1
    styles: dict[str, CurveStyle] = {}
    for names, flows in split_curves(shown, "point", keys, tuple(BeltParameters.model_fields)):
        style, label = look(names, len(styles))
        extra = {name: names[name] for name in names if name not in (*keys, "protocol")}
        label += describe(extra)
        if label not in styles and style in styles.values():
            # Another parameter tells these flows apart, which the paper's styles do not know.
            style = cycled(len(styles) + len(_ANGLES))
        style = styles.setdefault(label, style)
        pale = BESIDE if beside and flows["protocol"].iloc[0] == "converged" else {}
        for point in flows["point"]:
            part = table[table["point"] == point]
            low, high = part["mean"] - part["half_width"], part["mean"] + part["half_width"]
            axes.plot(part["z"], part["mean"], color=style.colour, linestyle=style.dashes, **pale)
            axes.fill_between(part["z"], low, high, color=style.colour, alpha=0.15, linewidth=0)
    for label, style in styles.items():
        axes.plot([], [], color=style.colour, linestyle=style.dashes, label=label)
    if beside:
        name_protocols(axes)
    axes.set_xlim(left=0)
    axes.set_ylim(*_range(table["mean"]))
    axes.set_xlabel("height above the belt z (⟨d⟩)")
    axes.set_ylabel(quantity.label)
    place_legend(figure, axes)
    return figure


def _range(means: pd.Series) -> tuple[float, float]:
    """Return the range of the vertical axis: that of the curves, however wide their bands are."""
    low, high = min(0.0, means.min()), max(0.0, means.max())
    room = 0.08 * (high - low) if high > low else 1.0
    return (low - room if low else 0.0), high + room


def profiles(data: FigureData, quantity: Quantity) -> pd.DataFrame:
    """Return the profiles of all points that have a completed replicate.

    Returns
    -------
    pandas.DataFrame
        A row per point and slice, up to the last slice that is not thinner than `THIN`: ``point``,
        ``z`` (⟨d⟩), ``mean`` and ``half_width`` (of its 95 % interval over the replicates; NaN for
        a single one). A slice that is empty in a replicate has no velocity.
    """
    parts = []
    for row in data.rows[data.rows["completed"] > 0].to_dict("records"):
        values, height = data.results.profile(row["point"], quantity.name)
        density, _ = data.results.profile(row["point"], DENSITY.name)
        dense = np.flatnonzero(density.mean(axis=0) * row["diameter"] ** 2 >= THIN)
        end = dense.max(initial=-1) + 1
        values = values[:, :end] * row["diameter"] ** quantity.power
        half_width = student_half_width(values)
        parts.append(
            pd.DataFrame(
                {
                    "point": row["point"],
                    "z": height[:end] / row["diameter"],
                    "mean": values.mean(axis=0),
                    "half_width": half_width,
                }
            )
        )
    return pd.concat(parts or [pd.DataFrame(columns=["point", "z", "mean", "half_width"])])


def table(data: FigureData, quantity: Quantity) -> pd.DataFrame:
    """Return the data behind a panel: a row per point and slice, units in the headings."""
    columns = parameter_columns(data.rows, "belt", (*NAMED, "initial_velocity", "protocol"))
    found = profiles(data, quantity).rename(
        columns={
            "z": "height above the belt [⟨d⟩]",
            "mean": quantity.heading,
            "half_width": f"half width of 95 % interval {quantity.heading.split()[-1]}",
        }
    )
    points = pd.DataFrame(columns | {"completed replicates": data.rows["completed"]})
    return points.merge(found, on="point", how="inner")


def notes(data: FigureData, quantity: Quantity) -> list[str]:
    """Return what the caption says of heights, bands and regimes."""
    completed = data.rows["completed"]
    several, single = completed[completed > 1], completed[completed == 1]
    sentences = [
        "z is measured from the present position of the belt, in slices of ⟨d⟩, up to the last one "
        f"with {THIN:g} beads per ⟨d⟩² or more."
    ]
    if quantity is VELOCITY:
        sentences.append("A slice that is empty in a replicate has no value.")
    if len(several):
        sentences.append(
            "Bands: Student's 95 % interval of the mean over "
            f"{counted(several)} replicates; they may reach beyond the axes."
        )
    if len(single):
        sentences.append(f"No band: one replicate ({points_text(len(single))}).")
    regimes = data.rows[completed > 0]["regime"].value_counts()
    named = ", ".join(f"{count} {regime}" for regime, count in regimes.items())
    return [*sentences, f"Regimes of the flows: {named}."] if named else sentences
