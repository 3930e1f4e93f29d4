"""Gallas et al. (1992), Fig. 7c: paths of the beads at 20 Hz around an obstacle."""

from sim.figures import belt_cell, belt_paths

NAMED = belt_cell.NAMED
LEAD = belt_paths.LEAD
PAPER = (
    "The paper: the local obstacle changes the paths of the whole system, as a comparison "
    "with Fig. 4c shows."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_paths.draw
table = belt_paths.table
