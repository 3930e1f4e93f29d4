"""Share of the beads within the belt's reach against frequency."""

import pandas as pd
from matplotlib.figure import Figure

from sim.dataset.measures.belt import EMPTY
from sim.figures import transport
from sim.figures.measures import measure_notes as notes
from sim.figures.measures import measure_table, measured
from sim.figures.style import LEVEL, CurveStyle, canvas, cycled, place_legend
from sim.figures.summary import FigureData

__all__ = ["LEAD", "NAMED", "PAPER", "draw", "notes", "table"]

NAMED = transport.NAMED
LEAD = (
    "Share of the beads whose centres are within the amplitude A_z of the mean position of the "
    "belt, against its frequency f, for several amplitudes. Dotted: 2 %."
)
PAPER = "The paper: above 60 Hz almost no bead is between the extreme positions of the belt."


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = canvas()
    transport.draw_curves(axes, _shares(data), "frequency", ("amplitude",), _look)
    axes.axhline(EMPTY, **LEVEL)
    axes.set_xlabel("frequency f (Hz)")
    axes.set_ylabel("share of the beads within the belt's reach")
    place_legend(figure, axes)
    return figure


def _look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    amplitude = names["amplitude"]
    style = transport.AMPLITUDES.get(amplitude, cycled(index + len(transport.AMPLITUDES)))
    return style, f"$A_z$ = {amplitude:g} ⟨d⟩"


def _shares(data: FigureData) -> pd.DataFrame:
    return measured(data, "base_occupancy")


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    names = ("frequency", *NAMED, "protocol")
    return measure_table(data, names, {"beads within the belt's reach [1]": _shares(data)})
