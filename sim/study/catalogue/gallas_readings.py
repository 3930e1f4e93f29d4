"""Gallas' Figs. 1a, 1c and 2a with damping by each bead's own mass and by that of the pair."""

from typing import Any

from sim.study.catalogue.gallas import (
    BLACK,
    BLUE,
    FLOW,
    GREEN,
    RED,
    USUAL,
    figure,
    usual_without,
)
from sim.study.catalogue.spec import FigureSpec

_EACH = (
    "for damping in proportion to each bead's own mass, as the equations are printed, and to the "
    "reduced mass of the pair, with which the forces on both beads are opposite."
)
_MASS = "{damping_mass} mass"
_FREQUENCY_AND_MASS = "f = {frequency:g} Hz, " + _MASS


def _panel(label: str, axis: str, curves: str, what: str, lead: str, **rest: Any) -> FigureSpec:
    return figure(
        f"readings_{label}",
        f"Fig. {label}, with either mass in the damping terms",
        axis,
        curves,
        title=f"{what} with damping by the own and by the reduced mass",
        lead=f"{lead}, {_EACH}",
        **rest,
    )


READINGS = (
    _panel(
        "1a",
        "frequency",
        "damping_mass",
        "Transport velocity against frequency",
        "Transport velocity V_x of the beads against the frequency f of the belt",
        kind="belt_curves",
        where=USUAL,
        named=FLOW,
        says="The paper: a rather rapid jump near 16 Hz, then a flux that grows monotonically.",
        options={
            "styles": {"own": (BLACK, "solid", "o"), "reduced": (RED, "dash_dot", "^")},
            "entry": _MASS,
        },
    ),
    _panel(
        "1c",
        "shear_damping",
        "frequency damping_mass",
        "Transport velocity against the shear friction coefficient",
        "Transport velocity V_x of the beads against the shear friction coefficient γ_s at several "
        "frequencies f of the belt",
        kind="belt_curves",
        where=usual_without(("shear_damping",)),
        named=FLOW,
        says="The paper: the flux rises rapidly up to γ_s = 10g and only gently from there on.",
        options={
            "styles": {
                (50.0, "own"): (BLACK, "solid", "o"),
                (50.0, "reduced"): (RED, "dash_dot", "^"),
                (20.0, "own"): (BLUE, "long_dash", "s"),
                (20.0, "reduced"): (GREEN, "dotted", "X"),
            },
            "entry": _FREQUENCY_AND_MASS,
        },
    ),
    _panel(
        "2a",
        "frequency",
        "damping_mass",
        "Number density above the belt",
        "Local number density ρ of the beads, in beads per ⟨d⟩², over the height z above the belt "
        "in mean diameters ⟨d⟩ at two frequencies f",
        kind="belt_profiles",
        where=USUAL | {"frequency": (20, 80)},
        named=("frequency", *FLOW),
        says=(
            "The paper: at low frequency the density has a plateau that ends almost abruptly near "
            "z = 9⟨d⟩; close to the belt it is very small."
        ),
        options={
            "quantity": "number_density",
            "keys": ("frequency", "damping_mass"),
            "styles": {
                (20.0, "own"): (BLUE, "long_dash"),
                (20.0, "reduced"): (BLACK, "solid"),
                (80.0, "own"): (GREEN, "dotted"),
                (80.0, "reduced"): (RED, "dash_dot"),
            },
            "entry": _FREQUENCY_AND_MASS,
        },
    ),
)
