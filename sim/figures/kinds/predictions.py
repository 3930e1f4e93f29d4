"""Measurements, and what a calibrated surrogate says of each."""

from sim.study.plot_kinds import Keys, Later, plot_kind

drawing = Later("sim.figures.calibration")
plot_kind(
    "predictions", keys=Keys(), table=drawing.predictions_table, notes=drawing.predictions_notes
)(drawing.draw_predictions)
