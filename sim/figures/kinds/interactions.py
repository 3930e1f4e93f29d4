"""Second-order Sobol' indices of pairs of parameters, with intervals."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.sensitivity")
plot_kind(
    "interactions", keys=Keys(), table=drawing.interactions_table, notes=drawing.interactions_notes
)(drawing.draw_interactions)
