"""Walton (1993), Fig. 1.6: profiles and configuration of a flow of depth 40."""

from sim.figures import chute_row

LEAD = chute_row.lead(40)
NAMED = chute_row.NAMED
PAPER = (
    "The paper: an almost uniformly dense, crystalline region without shear rides over a layer "
    "that shears and is less dense. Layers tend to be thinner, and flows faster, the deeper they "
    "are; flows deeper than 10 depend much on the stiffness of the spheres."
)

draw, table, notes = chute_row.draw, chute_row.table, chute_row.notes
