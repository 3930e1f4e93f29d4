"""Parallel coordinates: a line per point, coloured by an observable."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.parallel")
plot_kind(
    "parallel",
    keys=Keys(
        several="parameters",
        observable="y",
        shows=numbers,
        log=("y",),
        over="over {}",
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
