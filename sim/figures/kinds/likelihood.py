"""How likely a single run per point rises with a parameter, where a study has several."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.likelihood")
plot_kind(
    "likelihood",
    keys=Keys(
        axes=("x",),
        observable="y",
        shows=numbers,
        others=("curves", "panels"),
        what="probability that a single run per point rises in {}",
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
