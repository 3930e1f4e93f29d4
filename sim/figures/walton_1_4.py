"""Walton (1993), Fig. 1.4: profiles and configuration of a flow of depth 10."""

from sim.figures import chute_row

LEAD = chute_row.lead(10)
NAMED = chute_row.NAMED
PAPER = (
    "The paper: a region without shear, crystalline, rides over a relatively thin layer that "
    "shears and is less dense."
)

draw, table, notes = chute_row.draw, chute_row.table, chute_row.notes
