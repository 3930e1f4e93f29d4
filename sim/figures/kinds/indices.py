"""First-order and total Sobol' indices of each parameter, with intervals."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.sensitivity")
plot_kind("indices", keys=Keys(), table=drawing.indices_table, notes=drawing.indices_notes)(
    drawing.draw_indices
)
