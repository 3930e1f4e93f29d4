"""Gallas et al. (1992), Fig. 1a: transport velocity against frequency for three angles."""

from matplotlib.figure import Figure

from sim.figures import transport
from sim.figures.style import DASH_DOT, SHORT_DASH, CurveStyle, cycled
from sim.figures.summary import FigureData

NAMED = transport.NAMED
LEAD = (
    "Transport velocity V_x of the beads against the frequency f of the belt, "
    "for several angles α of the vibration."
)
PAPER = (
    "The paper: after a rather rapid jump near 16 Hz, at the same frequency for all angles, "
    "the flux grows monotonically and in the end linearly; flatter vibrations transport "
    "faster."
)

_STYLES = {
    60.0: (CurveStyle("#d55e00", DASH_DOT, "^"), "α = π/3"),
    45.0: (CurveStyle("#000000", "-", "o"), "α = π/4"),
    30.0: (CurveStyle("#0072b2", SHORT_DASH, "s"), "α = π/6"),
}


def draw(data: FigureData) -> Figure:
    """Draw the figure."""
    figure, axes = transport.draw_panel(data.rows, "frequency", ("vibration_angle",), _look)
    axes.set_xlabel("frequency f (Hz)")
    return figure


def _look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    angle = names["vibration_angle"]
    return _STYLES.get(angle, (cycled(index + len(_STYLES)), f"α = {angle:g}°"))
