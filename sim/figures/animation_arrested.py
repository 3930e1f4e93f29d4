"""Animation: spheres whose friction coefficient is more than twice tan θ."""

from dataclasses import replace

from sim.figures import moving_chute
from sim.figures.summary import FigureData

LEAD = moving_chute.lead(
    "The slowest flow of spheres whose friction coefficient is more than twice tan θ"
)
NAMED = moving_chute.NAMED
PAPER = (
    "The paper: friction coefficients that greatly exceed tan θ, by more than a factor of two, "
    "arrest the flow."
)

draw, notes = moving_chute.draw, moving_chute.notes


def select(data: FigureData) -> FigureData:
    """Narrow the points to the slowest."""
    slowest_first = data.rows.sort_values(["completed", "velocity"], ascending=[False, True])
    return moving_chute.select(replace(data, rows=slowest_first))
