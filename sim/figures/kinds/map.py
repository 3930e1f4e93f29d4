"""A map over two parameters: regimes and their boundaries, or an observable as a colour."""

from sim.study.plot_kinds import REGIME, Keys, Later, plot_kind
from sim.study.plottable import numbers

drawing = Later("sim.figures.map")
plot_kind(
    "map",
    keys=Keys(
        axes=("x", "y"),
        observable="colour",
        usual=REGIME,
        shows=numbers,
        log=("x", "y", "colour"),
        others=("panels", "beside"),
        of_papers=("x", "y", "curves", "log", "labels"),
        systems=("chute", "belt"),
        over="over {}",
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
