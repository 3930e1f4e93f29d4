"""A scatter matrix of several parameters and an observable."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.pairs")
plot_kind(
    "pairs",
    keys=Keys(
        several="parameters",
        observable="y",
        shows=numbers,
        log=("y",),
        over="over {}",
        most=6,
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
