"""Runs against what a surrogate predicts of each from all the others."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.surrogates")
plot_kind("agreement", keys=Keys(), table=drawing.agreement_table, notes=drawing.agreement_notes)(
    drawing.draw_agreement
)
