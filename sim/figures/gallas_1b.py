"""Gallas et al. (1992), Fig. 1b: transport velocity for several amplitudes and dampings."""

from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.style import CurveStyle, cycled
from sim.figures.summary import FigureData

NAMED = transport.NAMED
LEAD = (
    "Transport velocity V_x of the beads against the frequency f of the belt: lines for several "
    "amplitudes A_z of the vibration at γ = γ_s = 50g, markers alone for other damping "
    "coefficients (γ, γ_s), large and pale those of the converged protocol."
)
PAPER = (
    "The paper: all curves jump up and then grow monotonically; beads start to flow at about 16 Hz "
    "for amplitudes of 1 and 1.5 ⟨d⟩, at about 18 Hz for half a diameter, whatever the damping."
)

_DAMPINGS = {
    (0.0, 50.0): CurveStyle("#009e73", "none", "^"),
    (10.0, 10.0): CurveStyle("#cc79a7", "none", "X"),
    (50.0, 100.0): CurveStyle("#e69f00", "none", "s"),
}


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    keys = ("amplitude", "damping", "shear_damping")
    figure, axes = transport.draw_panel(data.rows, "frequency", keys, _look)
    axes.set_xlabel("frequency f (Hz)")
    return figure


def _look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    amplitude = names["amplitude"]
    damping = (names["damping"], names["shear_damping"])
    if damping == (50.0, 50.0):
        label = f"$A_z$ = {amplitude:g} ⟨d⟩"
        return transport.AMPLITUDES.get(amplitude, cycled(index)), label
    style = _DAMPINGS.get(damping, CurveStyle(cycled(index).colour, "none", cycled(index).marker))
    label = transport.pair(*damping)
    return style, label if amplitude == 1 else f"{label}, $A_z$ = {amplitude:g} ⟨d⟩"
