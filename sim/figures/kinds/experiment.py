"""How much a further measurement would tell, over its conditions."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.calibration")
plot_kind(
    "experiment", keys=Keys(), table=drawing.experiment_table, notes=drawing.experiment_notes
)(drawing.draw_experiment)
