"""Gallas et al. (1992), Fig. 7a: paths of the beads at 80 Hz around an obstacle."""

from sim.figures import belt_cell, belt_paths

NAMED = belt_cell.NAMED
LEAD = belt_paths.LEAD
PAPER = (
    "The paper: with the obstacle the paths are no stream as in Fig. 4d, but rather like "
    "those of Fig. 4c at a much lower frequency."
)

select = belt_cell.select
notes = belt_cell.notes
draw = belt_paths.draw
table = belt_paths.table
