"""A map of a surrogate over two parameters, with the runs and the boundary of the regime."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.surrogates")
plot_kind("surface", keys=Keys(), table=drawing.surface_table, notes=drawing.surface_notes)(
    drawing.draw_surface
)
