"""Limits that captions state and pictures keep to."""

#: Greatest depth n whose pictures show a portion of the cell: the half near the viewer.
LARGEST_PORTION = 10

#: Profiles of a chute flow end where this share of the spheres' volume is below.
SHARE = 0.995

#: Largest half width of an interval, relative to the mean, of chute flows that a line joins.
WIDEST_INTERVAL = 0.5

#: Flows slower than this (√(gσ)) that are not at rest are said to creep.
CREEP = 0.1

#: Greatest height of the beads in an animation (⟨d⟩); few beads of a gas fly higher.
TALLEST = 24.0
