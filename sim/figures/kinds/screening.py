"""Morris' screening: mean size and deviation of each parameter's effects."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.sensitivity")
plot_kind("screening", keys=Keys(), table=drawing.screening_table, notes=drawing.screening_notes)(
    drawing.draw_screening
)
