"""Walton (1993), Fig. 1.3: profiles and configuration of a flow of depth 5."""

from sim.figures import chute_row

LEAD = chute_row.lead(5)
NAMED = chute_row.NAMED
PAPER = (
    "The paper: up to about this depth the velocity usually rises monotonically with height, "
    "and flows of intermediate depth have their largest density inside."
)

draw, table, notes = chute_row.draw, chute_row.table, chute_row.notes
