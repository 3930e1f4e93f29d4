"""Onset of the belt's transport against its acceleration, for several amplitudes and angles."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.dataset.measures.belt import speed_along_x
from sim.figures import transport
from sim.figures.columns import parameter_columns
from sim.figures.family import draw_family
from sim.figures.style import LEVEL, CurveStyle, canvas, cycled, place_legend
from sim.figures.summary import FigureData
from sim.parameters import BeltParameters
from sim.parameters.belt import LEAST_TRANSPORT

NAMED = ("frequency", *transport.NAMED)
LEAD = (
    "Transport velocity V_x of the beads over that of the belt along x, A_x·2πf, against the "
    "largest acceleration of the belt, Γ = 4π²f²A_z/g, for several amplitudes A_z and angles α of "
    "the vibration, near the onset of transport. Dotted: Γ = 1, and the 2 % from which on beads "
    "are said to be transported."
)
PAPER = (
    "The paper: transport begins near 16 Hz whatever the angle, for A_z = ⟨d⟩ as for 1.5 ⟨d⟩, and "
    "near 18 Hz for 0.5 ⟨d⟩; at A_z = ⟨d⟩ that is Γ ≈ 1. An onset at the same Γ for all amplitudes "
    "is one at frequencies in proportion to 1/√A_z."
)

#: Parameters that name a curve.
_KEYS = ("amplitude", "vibration_angle")

#: Largest acceleration drawn: well within the flow.
_LARGEST = 3.0


def select(data: FigureData) -> FigureData:
    """Return what feeds the figure near the onset, velocities and intervals relative to the belt's.

    The acceleration of the belt is in the column ``acceleration_ratio``.
    """
    rows = data.rows
    vertical = rows["amplitude"] * rows["diameter"]
    rate = 2 * np.pi * rows["frequency"]
    along = speed_along_x(rows)
    relative = rows.assign(
        acceleration_ratio=rate**2 * vertical / rows["gravity"],
        velocity=rows["velocity"] / along,
        half_width=rows["half_width"] / along,
    )
    near = relative[relative["acceleration_ratio"] <= _LARGEST]
    return FigureData(near, data.boundaries, data.results)


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = canvas()
    names = tuple(name for name in BeltParameters.model_fields if name != "frequency")
    draw_family(axes, data.rows, "acceleration_ratio", _KEYS, names, _look)
    axes.axvline(1, **LEVEL)
    axes.axhline(LEAST_TRANSPORT, **LEVEL)
    axes.set_xlabel("acceleration of the belt Γ = $4π^2 f^2 A_z/g$")
    axes.set_ylabel("$V_x / (A_x 2πf)$")
    place_legend(figure, axes)
    return figure


def _look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    further = {name: value for name, value in names.items() if name not in _KEYS}
    label = f"$A_z$ = {names['amplitude']:g} ⟨d⟩, α = {names['vibration_angle']:g}°"
    return cycled(index), label + transport.describe(further)


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the figure, one row per point, units in the headings."""
    rows = data.rows
    return pd.DataFrame(
        parameter_columns(rows, "belt", (*NAMED, "protocol"))
        | {
            "acceleration of the belt [g]": rows["acceleration_ratio"],
            "velocity over the belt's along x [1]": rows["velocity"],
            "half width of 95 % interval [1]": rows["half_width"],
            "completed replicates": rows["completed"],
            "regime": rows["regime"],
            "quality of the mean": rows["quality"],
        }
    )
