"""Profiles over the height, or one profile against another in the same slices."""

from sim.study.plot_kinds import Keys, Later, plot_kind
from sim.study.plottable import profiles

drawing = Later("sim.figures.profiles")
plot_kind(
    "profiles",
    keys=Keys(
        observable="x",
        shows=profiles,
        second="y",
        log=("x",),
        others=("curves", "panels", "between", "beside"),
        of_papers=("x", "curves", "vary", "labels", "styles", "entry"),
        systems=("belt",),
        over="over the height",
    ),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
