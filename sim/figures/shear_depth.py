"""Height of the shearing layer against depth, for several restitutions and stiffnesses."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.errors import InputError
from sim.figures.caption import regime_sentence
from sim.figures.columns import parameter_columns
from sim.figures.over_depth import NAMED, label, set_depth_axis
from sim.figures.style import canvas, cycled, draw_curve, place_legend
from sim.figures.summary import FigureData, split_curves
from sim.outcome import student_half_width
from sim.parameters import ChuteParameters

__all__ = ["LEAD", "NAMED", "PAPER", "draw", "notes", "table"]

LEAD = (
    "Height δ_s of the shearing layer, in diameters σ, against the depth n = N/σ² of the flow for "
    "several coefficients of restitution e and stiffnesses K1. δ_s is where the time-averaged "
    "velocity reaches 90 % of that at the surface. Lines join flows that do not accelerate."
)
PAPER = (
    "The paper: more elastic spheres have a deeper shearing layer (Fig. 2); the thickness of the "
    "layer tends to decrease as the flows get deeper; spheres stiffer by one or two orders of "
    "magnitude have a significantly deeper one in flows deeper than 10 per σ², while flows of less "
    "than 5 per σ² hardly depend on the stiffness."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = canvas()
    rows = measured(data)
    # Drawn as velocities are: a mean, its interval, markers that tell the regime.
    heights = rows.assign(velocity=rows["height"], half_width=rows["height_half_width"])
    names = ("restitution", "stiffness")
    curves = split_curves(heights, "depth", names, tuple(ChuteParameters.model_fields))
    for index, (values, curve) in enumerate(curves):
        known = curve[curve["height"].notna()]
        draw_curve(axes, known, "depth", cycled(index), label(values), ("accelerating",))
    set_depth_axis(axes, data.rows["depth"])
    # Intervals over two replicates may be wider than all the heights.
    highest = rows["height"].max()
    axes.set_ylim(0, min(axes.get_ylim()[1], 1.5 * highest) if highest > 0 else 1)
    axes.set_ylabel("height of the shearing layer $δ_s$ (σ)")
    place_legend(figure, axes)
    return figure


def measured(data: FigureData) -> pd.DataFrame:
    """Return the points with ``height`` δ_s (σ) and the half width of its 95 % interval.

    It is the mean over the completed replicates in which it is known; a single one has no interval.

    Raises
    ------
    InputError
        When the dataset has no such measure.
    """
    if "shear_depth" not in data.results.dataset:
        raise InputError("no shear_depth in the dataset")
    values = data.results.dataset["shear_depth"].sel(point=data.rows["point"].values).values
    values = values / data.rows["diameter"].to_numpy()[:, None]
    known = [each[np.isfinite(each)] for each in values]
    return data.rows.assign(
        height=[each.mean() if each.size else np.nan for each in known],
        height_half_width=[float(student_half_width(each)) for each in known],
    )


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of error bars and markers."""
    bars = "Error bars: Student's 95 % interval of the mean over replicates, none where only one."
    return [bars, regime_sentence(data.rows)]


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    rows = measured(data)
    return pd.DataFrame(
        parameter_columns(rows, "chute", ("depth", *NAMED, "protocol"))
        | {
            "height of the shearing layer [σ]": rows["height"],
            "half width of 95 % interval [σ]": rows["height_half_width"],
            "completed replicates": rows["completed"],
            "regime": rows["regime"],
            "quality of the mean": rows["quality"],
        }
    )
