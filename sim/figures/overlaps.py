"""How much spheres overlap in chute flows against depth, for several stiffnesses."""

from dataclasses import replace

import pandas as pd
from matplotlib.figure import Figure

from sim.figures.measures import measure_notes as notes
from sim.figures.measures import measure_table, measured
from sim.figures.over_depth import JOINED, NAMED, label, set_depth_axis, unjoined
from sim.figures.style import (
    LEVEL,
    LONG_DASH,
    canvas,
    cycled,
    draw_curve,
    mark_cut_bars,
    place_legend,
)
from sim.figures.summary import FigureData, split_curves
from sim.parameters import ChuteParameters

__all__ = ["LEAD", "NAMED", "PAPER", "draw", "notes", "table"]

LEAD = (
    "Overlap of touching spheres, in diameters σ, against the depth n = N/σ² of the flow for "
    "several stiffnesses K1: median of all contacts at the samples of the averaging window "
    "(dashed) and the overlap that one of a thousand exceeds (lines). Dotted: 0.5 % and 5 %. "
    f"{JOINED}"
)
PAPER = (
    "The paper: the softest spheres overlap by the order of half a percent at rest and by up to "
    "five percent in the shearing layer of the deepest flow; in flows of less than 5 per σ² by "
    "half a percent in motion."
)

#: Measures of the dataset: dashes, entry in the legend, heading of the table.
_MEASURES = {
    "overlap_999": ("-", "one of a thousand", "overlap that one of a thousand exceeds [σ]"),
    "median_overlap": (LONG_DASH, "median", "median overlap [σ]"),
}
_NAMED_BY_PAPER = (0.005, 0.05)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = canvas()
    for measure, (dashes, what, _) in _MEASURES.items():
        rows = measured(data, measure)
        curves = split_curves(rows, "depth", ("stiffness",), tuple(ChuteParameters.model_fields))
        for index, (values, curve) in enumerate(curves):
            style = replace(cycled(index), dashes=dashes)
            draw_curve(axes, curve, "depth", style, f"{label(values)}, {what}", unjoined)
    for level in _NAMED_BY_PAPER:
        axes.axhline(level, **LEVEL)
    set_depth_axis(axes, data.rows["depth"])
    axes.set_yscale("log")
    axes.set_ylabel("overlap (σ)")
    mark_cut_bars(axes)
    place_legend(figure, axes)
    return figure


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    measures = {heading: measured(data, name) for name, (_, _, heading) in _MEASURES.items()}
    return measure_table(data, ("depth", *NAMED, "protocol"), measures)
