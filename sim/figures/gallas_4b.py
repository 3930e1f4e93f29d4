"""Gallas et al. (1992), Fig. 4b: paths of the beads at 10 Hz with little shear friction."""

from sim.figures import belt_cell, belt_paths

NAMED = belt_cell.NAMED
LEAD = belt_paths.LEAD
PAPER = (
    "The paper: as the shear friction becomes small, the tilt of the paths tends to π/2, "
    "provided that the frequency is low."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_paths.draw
table = belt_paths.table
