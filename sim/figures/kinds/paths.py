"""Paths of the beads over one cycle, as in Gallas' Figs. 4, 7a and 7c."""

from sim.study.plot_kinds import Keys, Later, Shown, plot_kind

drawing = Later("sim.figures.beads")
plot_kind(
    "paths",
    keys=Keys(systems=("belt",), particles=Shown.PATH),
    table=drawing.paths_table,
    notes=drawing.notes,
    select=drawing.select,
)(drawing.draw_paths)
