"""A posterior: a histogram of each parameter, and regions of each pair."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.calibration")
plot_kind("posterior", keys=Keys(), table=drawing.posterior_table, notes=drawing.posterior_notes)(
    drawing.draw_posterior
)
