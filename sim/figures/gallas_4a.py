"""Gallas et al. (1992), Fig. 4a: paths of the beads at 10 Hz."""

from sim.figures import belt_cell, belt_paths

NAMED = belt_cell.NAMED
LEAD = belt_paths.LEAD
PAPER = (
    "The paper: all beads move synchronously along ellipses, whose tilt grows with the angle "
    "of vibration."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_paths.draw
table = belt_paths.table
