"""A section of a surrogate along one parameter, with its band and the runs near it."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.surrogates")
plot_kind("section", keys=Keys(), table=drawing.section_table, notes=drawing.section_notes)(
    drawing.draw_section
)
