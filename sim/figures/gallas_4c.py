"""Gallas et al. (1992), Fig. 4c: paths of the beads at 20 Hz."""

from sim.figures import belt_cell, belt_paths

NAMED = belt_cell.NAMED
LEAD = belt_paths.LEAD
PAPER = (
    "The paper: as the beads begin to flow, at frequencies not too high, they move along "
    "sinusoidal curves."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_paths.draw
table = belt_paths.table
