"""Gallas et al. (1992), Fig. 7b: beads at the start of a cycle at 80 Hz around an obstacle."""

from sim.figures import belt_cell, belt_snapshots

NAMED = belt_cell.NAMED
LEAD = belt_snapshots.LEAD
PAPER = (
    "The paper: the obstacle changes the paths much, but causes no turbulence at high frequency."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_snapshots.draw
table = belt_snapshots.table
