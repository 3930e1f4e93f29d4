"""Gallas' Figs. 4, 5 and 7: paths of the beads, and where they are at the start of a cycle."""

from typing import Any

from sim.study.catalogue.gallas import BED, SHAKING, USUAL, WINDOW, panel
from sim.study.catalogue.spec import FigureSpec

_NAMED = ("frequency", *SHAKING, "obstacle", *BED, "steps_per_cycle", *WINDOW)

_PATHS = (
    "Paths of the beads during a single cycle of the vibration in the steady state, in the frame "
    "of the laboratory: the centre of each bead after every 50 of 2000 steps (every fortieth of "
    "the cycle, both ends included). The horizontal line is the average position of the belt; "
    "lengths are in mean diameters ⟨d⟩."
)
_SNAPSHOT = (
    "Beads (circles, to scale) at the beginning of a cycle, at the end of the run. The linear "
    "segments that begin at their centres are their velocities in the frame of the laboratory, to "
    "the scale at the top right. Dotted lines are the highest and the lowest position of the belt, "
    "the solid line its average one, where it is at that moment; lengths are in mean diameters ⟨d⟩."
)


def _paths(label: str, title: str, says: str, **where: Any) -> FigureSpec:
    return panel(
        label,
        kind="belt_paths",
        title=f"Paths of the beads over one cycle {title}",
        where=USUAL | where,
        lead=_PATHS,
        named=_NAMED,
        says=f"The paper: {says}",
    )


def _snapshot(label: str, title: str, says: str, **where: Any) -> FigureSpec:
    return panel(
        label,
        kind="belt_snapshots",
        title=f"Beads at the beginning of a cycle {title}",
        where=USUAL | where,
        lead=_SNAPSHOT,
        named=_NAMED,
        says=f"The paper: {says}",
    )


FIGS_4_AND_5 = (
    _paths(
        "4a",
        "at 10 Hz",
        "all beads move synchronously along ellipses, whose tilt grows with the angle of "
        "vibration.",
        frequency=10,
    ),
    _paths(
        "4b",
        "at 10 Hz with little shear friction",
        "as the shear friction becomes small, the tilt of the paths tends to π/2, provided that "
        "the frequency is low.",
        frequency=10,
        shear_damping=1,
    ),
    _paths(
        "4c",
        "at 20 Hz",
        "as the beads begin to flow, at frequencies not too high, they move along sinusoidal "
        "curves.",
        frequency=20,
    ),
    _paths(
        "4d",
        "at 80 Hz",
        "with frequency the paths become flatter, until the beads flow together as a stream.",
        frequency=80,
    ),
    _paths(
        "4e",
        "at 80 Hz without shear friction",
        "without shear friction the beads move essentially vertically.",
        frequency=80,
        shear_damping=0,
    ),
    _snapshot(
        "5a",
        "at 10 Hz",
        "at low frequency the whole block of beads moves together and follows the belt.",
        frequency=10,
        vibration_angle=60,
    ),
    _snapshot(
        "5b",
        "at 40 Hz with little friction",
        "with frequency the upper surface is fluidised first, some beads jump, and the packing "
        "gets holes.",
        frequency=40,
        vibration_angle=30,
        damping=10,
        shear_damping=10,
    ),
    _snapshot(
        "5c",
        "at 100 Hz",
        "above about 60 Hz a big void develops at the bottom, and almost no bead is between the "
        "extreme positions of the belt.",
        frequency=100,
    ),
    _snapshot(
        "5d",
        "at 100 Hz with little damping",
        "with lower friction coefficients the layer above the void is less dense than in Fig. 5c.",
        frequency=100,
        damping=1,
    ),
)

FIG_7 = (
    _paths(
        "7a",
        "at 80 Hz around an obstacle",
        "with the obstacle the paths are no stream as in Fig. 4d, but rather like those of Fig. 4c "
        "at a much lower frequency.",
        frequency=80,
        obstacle=1.5,
    ),
    _snapshot(
        "7b",
        "at 80 Hz around an obstacle",
        "the obstacle changes the paths much, but causes no turbulence at high frequency.",
        frequency=80,
        obstacle=1.5,
    ),
    _paths(
        "7c",
        "at 20 Hz around an obstacle",
        "the local obstacle changes the paths of the whole system, as a comparison with Fig. 4c "
        "shows.",
        frequency=20,
        obstacle=1.5,
    ),
)
