"""Walton (1993), Fig. 2: mean velocity against depth for several materials."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.family import draw_family
from sim.figures.over_depth import NAMED, label, set_depth_axis
from sim.figures.style import canvas, cycled, place_legend
from sim.figures.summary import FigureData
from sim.parameters import ChuteParameters

__all__ = ["LEAD", "NAMED", "PAPER", "draw"]

LEAD = (
    "Mean velocity V of monodisperse spheres on a frictional inclined plane against the depth "
    "n = N/σ² of the flow, for several coefficients of restitution e and of friction μ "
    "(right: in units of √(gσ)). Lines join flows that do not accelerate. Flows beyond the scale "
    "are arrowheads at its top, with their velocities in m/s."
)
PAPER = (
    "The paper: the mean velocity tends to increase with depth; flows of one to two particles per "
    "σ² are the slowest, and those of half a particle per σ² accelerate without bound; the more "
    "elastic spheres flow slower and have a deeper shearing layer at the bottom."
)
_HEADROOM = 1.05
_BAND = 1.14


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    rows = data.rows
    figure, axes = canvas()
    ceiling = _ceiling(rows)
    draw_family(
        axes,
        rows[~(rows["velocity"] > ceiling)],
        "depth",
        ("restitution", "friction"),
        tuple(ChuteParameters.model_fields),
        lambda names, index: (cycled(index), label(names)),
        ("accelerating",),
    )
    above = rows[rows["velocity"] > ceiling]
    set_depth_axis(axes, rows["depth"])
    axes.set_ylim(0, ceiling if above.empty else _BAND * ceiling)
    _mark_off_scale(axes, above, (0.7 + 0.3 * _BAND) * ceiling)
    axes.set_ylabel("mean velocity V (m/s)")
    unit = float(np.sqrt(rows["gravity"] * rows["diameter"]).iloc[0])
    right = axes.secondary_yaxis("right", functions=(lambda v: v / unit, lambda v: v * unit))
    right.set_ylabel("V / √(gσ)")
    axes.spines["right"].set_visible(True)
    place_legend(figure, axes)
    return figure


def _ceiling(rows: pd.DataFrame) -> float:
    """Return the top of the vertical axis: the flows that do not accelerate fill it."""
    bounded = rows[(rows["completed"] > 0) & (rows["regime"] != "accelerating")]
    if bounded.empty:
        bounded = rows[rows["completed"] > 0]
    top = (bounded["velocity"] + bounded["half_width"].fillna(0)).max()
    return _HEADROOM * top if top > 0 else 1.0


def _mark_off_scale(axes: Axes, rows: pd.DataFrame, height: float) -> None:
    """Put an open arrowhead above all other data at each depth with points off the scale."""
    for depth, above in rows.groupby("depth"):
        low, high = (f"{value:.2g}" for value in (above["velocity"].min(), above["velocity"].max()))
        axes.plot(depth, height, "^", color="#444444", markerfacecolor="white")
        axes.annotate(
            low if low == high else f"{low} … {high}",
            (depth, height),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            fontsize=7.5,
            color="#444444",
        )
