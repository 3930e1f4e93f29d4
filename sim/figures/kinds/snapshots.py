"""Beads at the beginning of a cycle, as in Gallas' Figs. 5 and 7b: circles with velocities."""

from sim.study.plot_kinds import Keys, Later, Shown, plot_kind

drawing = Later("sim.figures.beads")
plot_kind(
    "snapshots",
    keys=Keys(systems=("belt",), particles=Shown.STATE),
    table=drawing.beads_table,
    notes=drawing.notes,
    select=drawing.select,
)(drawing.draw_snapshots)
