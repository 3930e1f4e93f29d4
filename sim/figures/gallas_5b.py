"""Gallas et al. (1992), Fig. 5b: beads at the start of a cycle at 40 Hz with little friction."""

from sim.figures import belt_cell, belt_snapshots

NAMED = belt_cell.NAMED
LEAD = belt_snapshots.LEAD
PAPER = (
    "The paper: with frequency the upper surface is fluidised first, some beads jump, and the "
    "packing gets holes."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_snapshots.draw
table = belt_snapshots.table
