"""What the figures of the vibrating belt share: values and names of parameters in the paper."""

from collections.abc import Container
from typing import Any

from sim.study.catalogue.spec import FigureSpec

DAMPED = {"damping": 50, "shear_damping": 50}
AT_45 = {"amplitude": 1, "vibration_angle": 45}
FROM_REST = {"initial_velocity": 0, "prior_frequency": 0}
USUAL = {**AT_45, **FROM_REST, **DAMPED, "obstacle": 0}

#: Parameters that captions give.
SHAKING = ("vibration_angle", "amplitude", "damping", "shear_damping")
BED = ("beads", "width")
WINDOW = ("transient", "average")
FLOW = (*SHAKING, *BED, *WINDOW)

#: Colours of Okabe and Ito, told apart by colour-blind readers.
BLACK, BLUE, RED, GREEN, PINK, ORANGE = (
    "#000000",
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
)


def usual_without(names: Container[str]) -> dict[str, Any]:
    """Return the usual values of all parameters but those that a figure is over."""
    return {name: value for name, value in USUAL.items() if name not in names}


def figure(name: str, place: str, axes: str = "", curves: str = "", **rest: Any) -> FigureSpec:
    """Return a figure of the belt; ``place`` says what of the paper it is about."""
    return FigureSpec(
        name=name,
        paper=f"Gallas et al. (1992), {place}",
        system="belt",
        axes=tuple(axes.split()),
        curves=tuple(curves.split()),
        **rest,
    )


def panel(label: str, axes: str = "", curves: str = "", **rest: Any) -> FigureSpec:
    """Return one panel of the paper's figures."""
    return figure(f"gallas_{label}", f"Fig. {label}", axes, curves, **rest)
