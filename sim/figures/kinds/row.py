"""A chute flow as in Walton's Figs. 1.1 to 1.6: profiles of velocity and packing, and spheres."""

from sim.study.plot_kinds import Keys, Later, Shown, plot_kind

drawing = Later("sim.figures.row")
plot_kind(
    "row",
    keys=Keys(systems=("chute",), particles=Shown.STATE),
    table=drawing.table,
    notes=drawing.notes,
)(drawing.draw)
