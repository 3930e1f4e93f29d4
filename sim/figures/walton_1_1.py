"""Walton (1993), Fig. 1.1: profiles and configuration of a flow of depth 1.24."""

from sim.figures import chute_row

LEAD = chute_row.lead(1.24)
NAMED = chute_row.NAMED
PAPER = (
    "The paper: with between one and two particles per σ² the flow is steady and slower than at "
    "all other depths; its velocity rises monotonically, and its density falls monotonically, "
    "with height."
)

draw, table, notes = chute_row.draw, chute_row.table, chute_row.notes
