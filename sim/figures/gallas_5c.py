"""Gallas et al. (1992), Fig. 5c: beads at the start of a cycle at 100 Hz."""

from sim.figures import belt_cell, belt_snapshots

NAMED = belt_cell.NAMED
LEAD = belt_snapshots.LEAD
PAPER = (
    "The paper: above about 60 Hz a big void develops at the bottom, and almost no bead is "
    "between the extreme positions of the belt."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_snapshots.draw
table = belt_snapshots.table
