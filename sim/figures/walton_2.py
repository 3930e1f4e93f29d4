"""Walton (1993), Fig. 2: mean velocity against depth for several materials."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.figures.over_depth import APART, JOINED, NAMED, draw_curves, set_depth_axis, unjoined
from sim.figures.style import canvas, mark_cut_bars, place_legend
from sim.figures.summary import FigureData

__all__ = ["LEAD", "NAMED", "PAPER", "draw"]

LEAD = (
    "Mean velocity V of monodisperse spheres on a frictional inclined plane against the depth "
    "n = N/σ² of the flow, for several coefficients of restitution e and of friction μ "
    "(right: in units of √(gσ)). Flows beyond the scale are markers at its top, with an arrow and "
    f"their velocities in m/s above them. {JOINED} {APART}"
)
PAPER = (
    "The paper: the mean velocity tends to increase with depth; flows of one to two particles per "
    "σ² are the slowest, and those of half a particle per σ² accelerate without bound; the more "
    "elastic spheres flow slower and have a deeper shearing layer at the bottom."
)
_HEADROOM = 1.05
_EDGE = 1.02


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    rows = data.rows
    figure, axes = canvas()
    ceiling = _ceiling(rows)
    above = rows["velocity"] > ceiling
    held = {"velocity": rows["velocity"].clip(upper=ceiling)}
    draw_curves(
        axes,
        rows.assign(**held, half_width=rows["half_width"].mask(above)),
        ("restitution", "friction"),
        lambda part: unjoined(rows.loc[part.index]) | above.loc[part.index],
    )
    set_depth_axis(axes, rows["depth"])
    axes.set_ylim(0, _EDGE * ceiling if above.any() else ceiling)
    mark_cut_bars(axes)
    _name_off_scale(axes, rows[above])
    axes.set_ylabel("mean velocity V (m/s)")
    unit = float(np.sqrt(rows["gravity"] * rows["diameter"]).iloc[0])
    right = axes.secondary_yaxis("right", functions=(lambda v: v / unit, lambda v: v * unit))
    right.set_ylabel("V / √(gσ)")
    axes.spines["right"].set_visible(True)
    place_legend(figure, axes)
    return figure


def _ceiling(rows: pd.DataFrame) -> float:
    """Return the top of the vertical axis: the flows that do not accelerate fill it."""
    bounded = rows[~unjoined(rows)]
    bounded = bounded[bounded["completed"] > 0]
    if bounded.empty:
        bounded = rows[rows["completed"] > 0]
    top = (bounded["velocity"] + bounded["half_width"].fillna(0)).max()
    return _HEADROOM * top if top > 0 else 1.0


def _name_off_scale(axes: Axes, rows: pd.DataFrame) -> None:
    """Write above the axes, where nothing strikes it, which velocities are off the scale."""
    for depth, above in rows.groupby("depth"):
        low, high = (f"{value:.2g}" for value in (above["velocity"].min(), above["velocity"].max()))
        axes.annotate(
            "↑ " + (low if low == high else f"{low} … {high}"),
            (depth, 1),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0, 2),
            textcoords="offset points",
            ha="center",
            fontsize=7.5,
            color="#444444",
        )
