"""Onset of transport on the belt: frequency against amplitude, and where the bed would lift off."""

import numpy as np
from matplotlib.figure import Figure

from sim.figures.boundaries import boundary_notes, draw_boundaries
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.style import THEORY, canvas, place_legend


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    rows = data.rows
    figure, axes = canvas()
    draw_boundaries(axes, data.boundaries, data.spec.axes)
    smallest, largest = rows["amplitude"][rows["amplitude"] > 0].agg(["min", "max"])
    amplitude = np.linspace(0.9 * smallest, 1.05 * largest, 200)
    for (gravity, diameter), _ in rows.groupby(["gravity", "diameter"]):
        frequency = np.sqrt(gravity / (amplitude * diameter)) / (2 * np.pi)
        axes.plot(amplitude, frequency, label="$Γ = 4π^2 f^2 A_z/g$ = 1", **THEORY)
    axes.set_xlabel("vertical amplitude $A_z$ (⟨d⟩)")
    axes.set_ylabel("onset frequency f (Hz)")
    place_legend(figure, axes)
    return figure


KIND = Kind(draw, notes=boundary_notes)
