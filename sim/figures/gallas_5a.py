"""Gallas et al. (1992), Fig. 5a: beads at the start of a cycle at 10 Hz."""

from sim.figures import belt_cell, belt_snapshots

NAMED = belt_cell.NAMED
LEAD = belt_snapshots.LEAD
PAPER = "The paper: at low frequency the whole block of beads moves together and follows the belt."

select = belt_cell.select
notes = belt_cell.notes
draw = belt_snapshots.draw
table = belt_snapshots.table
