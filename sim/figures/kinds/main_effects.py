"""Main effects: the mean of an observable along each of several parameters."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.main_effects")
plot_kind(
    "main_effects",
    keys=Keys(
        several="parameters",
        observable="y",
        shows=numbers,
        log=("y",),
        over="against {}",
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
