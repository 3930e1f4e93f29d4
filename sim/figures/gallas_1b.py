"""Gallas et al. (1992), Fig. 1b: transport velocity for several amplitudes and dampings."""

from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.style import DASH_DOT, SHORT_DASH, CurveStyle, cycled
from sim.figures.summary import FigureData

NAMED = transport.NAMED
LEAD = (
    "Transport velocity V_x of the beads against the frequency f of the belt: lines for several "
    "amplitudes A_z of the vibration at γ = γ_s = 50g, markers alone for other damping "
    "coefficients (γ, γ_s)."
)
PAPER = (
    "The paper: larger amplitudes transport faster and start at about the same 16 Hz (18 Hz "
    "for half a diameter); other damping coefficients give similar curves."
)

_AMPLITUDES = {
    1.5: CurveStyle("#d55e00", DASH_DOT),
    1.0: CurveStyle("#000000", "-"),
    0.5: CurveStyle("#0072b2", SHORT_DASH),
}
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
        return _AMPLITUDES.get(amplitude, cycled(index)), label
    style = _DAMPINGS.get(damping, CurveStyle(cycled(index).colour, "none", cycled(index).marker))
    label = f"(γ, γ$_s$) = ({_in_g(damping[0])}, {_in_g(damping[1])})"
    return style, label if amplitude == 1 else f"{label}, $A_z$ = {amplitude:g} ⟨d⟩"


def _in_g(value: float) -> str:
    return f"{value:g}g" if value else "0"
