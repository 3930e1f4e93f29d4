"""Gallas et al. (1992), Fig. 4e: paths of the beads at 80 Hz without shear friction."""

from sim.figures import belt_cell, belt_paths

NAMED = belt_cell.NAMED
LEAD = belt_paths.LEAD
PAPER = "The paper: without shear friction the beads move essentially vertically."

select = belt_cell.select
notes = belt_cell.notes
draw = belt_paths.draw
table = belt_paths.table
