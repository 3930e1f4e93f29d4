"""Density waves on the belt against frequency: right after the start, and later."""

from functools import partial

import pandas as pd
from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.family import draw_family
from sim.figures.measures import measure_notes as notes
from sim.figures.measures import measure_table, measured
from sim.figures.style import LONG_DASH, CurveStyle, canvas, place_legend
from sim.figures.summary import FigureData
from sim.parameters import BeltParameters

__all__ = ["LEAD", "NAMED", "PAPER", "draw", "notes", "table"]

NAMED = transport.NAMED
LEAD = (
    "Power of the five longest waves of the density along the belt, 1 for beads at random places, "
    "against the frequency f: over the first 10 cycles from rest, and over the averaging window."
)
PAPER = "The paper: dense regions move through the bed, more so right after the shaking starts."

#: Measures of the dataset: look, entry in the legend, heading of the table.
_MEASURES = {
    "early_wave_power": (
        CurveStyle("#0072b2", LONG_DASH, "s"),
        "first 10 cycles",
        "power in the first 10 cycles [1]",
    ),
    "wave_power": (
        CurveStyle("#000000", "-", "o"),
        "averaging window",
        "power in the averaging window [1]",
    ),
}


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = canvas()
    for name, (style, entry, _) in _MEASURES.items():
        draw_family(
            axes,
            measured(data, name),
            "frequency",
            ("protocol",),
            tuple(BeltParameters.model_fields),
            partial(_look, style, entry),
        )
    axes.set_ylim(bottom=0)
    axes.set_xlabel("frequency f (Hz)")
    axes.set_ylabel("power of long density waves")
    place_legend(figure, axes)
    return figure


def _look(
    style: CurveStyle, entry: str, names: dict[str, object], _: int
) -> tuple[CurveStyle, str]:
    return style, entry + transport.describe(names)


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    measures: dict[str, pd.DataFrame] = {
        heading: measured(data, name) for name, (_, _, heading) in _MEASURES.items()
    }
    return measure_table(data, ("frequency", *NAMED, "protocol"), measures)
