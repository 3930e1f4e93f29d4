"""Onset of transport on the belt: frequency against amplitude, and where the bed would lift off."""

import numpy as np
from matplotlib.figure import Figure

from sim.figures.regime_map import THEORY, draw_boundaries
from sim.figures.style import canvas, place_legend
from sim.figures.summary import FigureData

LEAD = (
    "Frequency f at which transport begins on the vibrating belt against the vertical amplitude "
    "A_z: intervals found by refinement. Dotted: the acceleration of the belt "
    "reaches that of gravity, Γ = 4π²f²A_z/g = 1. Transport is where the 95 % interval of every "
    "bed's mean velocity lies above 2 % of the velocity amplitude of the belt along x, no "
    "transport where it lies below."
)
NAMED = (
    "vibration_angle",
    "damping",
    "shear_damping",
    "beads",
    "width",
    "steps_per_cycle",
    "transient",
    "average",
)
PAPER = (
    "The paper: onset near 16 Hz for amplitudes of 1 and 1.5 ⟨d⟩, near 18 Hz for half a "
    "diameter; for one diameter that is Γ ≈ 1."
)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    rows = data.rows
    figure, axes = canvas()
    draw_boundaries(axes, data.boundaries, ("amplitude", "frequency"))
    smallest, largest = rows["amplitude"][rows["amplitude"] > 0].agg(["min", "max"])
    amplitude = np.linspace(0.9 * smallest, 1.05 * largest, 200)
    for (gravity, diameter), _ in rows.groupby(["gravity", "diameter"]):
        frequency = np.sqrt(gravity / (amplitude * diameter)) / (2 * np.pi)
        axes.plot(amplitude, frequency, label="$Γ = 4π^2 f^2 A_z/g$ = 1", **THEORY)
    axes.set_xlabel("vertical amplitude $A_z$ (⟨d⟩)")
    axes.set_ylabel("onset frequency f (Hz)")
    place_legend(figure, axes)
    return figure
