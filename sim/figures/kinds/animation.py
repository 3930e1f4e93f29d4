"""An animation of one point: spheres on the plane, or beads over a cycle of the belt."""

from sim.study.plot_kinds import Keys, Later, Shown, plot_kind

drawing = Later("sim.figures.animation")
plot_kind(
    "animation",
    keys=Keys(of_papers=("point",), systems=("chute", "belt"), particles=Shown.PATH, animated=True),
    notes=drawing.notes,
    select=drawing.select,
)(drawing.draw)
