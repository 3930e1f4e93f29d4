"""Curves of a number, with intervals, against a parameter or another number."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.curves")
plot_kind(
    "curves",
    keys=Keys(
        axes=("x",),
        observable="y",
        shows=numbers,
        second="x",
        log=("x", "y"),
        others=("curves", "panels", "beside", "fit"),
        of_papers=(
            *("x", "curves", "panels", "log", "labels"),
            *("levels", "level", "quantities", "styles", "entry", "relative", "alike"),
        ),
        systems=("chute", "belt"),
    ),
    table=drawing.table,
    notes=drawing.notes,
    select=drawing.select,
)(drawing.draw)
