"""Gallas et al. (1992), Fig. 5d: beads at the start of a cycle at 100 Hz with little damping."""

from sim.figures import belt_cell, belt_snapshots

NAMED = belt_cell.NAMED
LEAD = belt_snapshots.LEAD
PAPER = (
    "The paper: with lower friction coefficients the layer above the void is less dense than "
    "in Fig. 5c."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_snapshots.draw
table = belt_snapshots.table
