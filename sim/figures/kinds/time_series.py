"""Time series of replicates, read from their run files."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import series

drawing = Later("sim.figures.time_series")
plot_kind(
    "time_series",
    keys=Keys(
        observable="y",
        shows=series,
        log=("x", "y"),
        others=("curves", "panels"),
        over="against time",
        from_runs=True,
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
