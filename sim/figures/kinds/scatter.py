"""Points scattered in several parameters: an observable against one, or another observable."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.scatter")
plot_kind(
    "scatter",
    keys=Keys(
        axes=("x",),
        observable="y",
        shows=numbers,
        second="x",
        log=("x", "y", "colour"),
        others=("colour", "panels", "beside"),
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
