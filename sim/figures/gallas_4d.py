"""Gallas et al. (1992), Fig. 4d: paths of the beads at 80 Hz."""

from sim.figures import belt_cell, belt_paths

NAMED = belt_cell.NAMED
LEAD = belt_paths.LEAD
PAPER = (
    "The paper: with frequency the paths become flatter, until the beads flow together as a stream."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_paths.draw
table = belt_paths.table
