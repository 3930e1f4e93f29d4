"""Distribution of an observable over the replicates of each point."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.distribution")
plot_kind(
    "distribution",
    keys=Keys(
        axes=("x",),
        observable="y",
        shows=numbers,
        log=("y",),
        others=("curves", "panels"),
        what="{} of each replicate",
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
