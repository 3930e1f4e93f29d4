"""Gallas' Figs. 2 and 3: number density and velocity over the height above the belt."""

from typing import Any

from sim.study.catalogue.gallas import (
    AT_45,
    BLACK,
    BLUE,
    FLOW,
    GREEN,
    RED,
    USUAL,
    panel,
)
from sim.study.catalogue.spec import FigureSpec

_NAMED = ("frequency", *FLOW)

_FREQUENCIES = {
    "keys": ("frequency",),
    "styles": {
        10.0: (BLACK, "solid"),
        20.0: (BLUE, "long_dash"),
        60.0: (RED, "dash_dot"),
        80.0: (GREEN, "dotted"),
    },
    "entry": "f = {frequency:g} Hz",
}
_ANGLES = {
    "keys": ("vibration_angle",),
    "styles": {
        90.0: (GREEN, "dotted"),
        60.0: (RED, "dash_dot"),
        45.0: (BLACK, "solid"),
        30.0: (BLUE, "short_dash"),
    },
    "entry": "α = {vibration_angle:g}°",
    "entries": {90.0: "α = π/2", 60.0: "α = π/3", 45.0: "α = π/4", 30.0: "α = π/6"},
}
_DAMPINGS = {
    "look": "damping",
    "keys": ("damping", "shear_damping"),
    "styles": {
        (10.0, 10.0): (BLUE, "short_dash"),
        (0.0, 50.0): (RED, "dash_dot"),
        (50.0, 100.0): (BLACK, "solid"),
    },
    "fast_start": (GREEN, "long_dash"),
}

_READ_AS = (
    "(the paper's caption has π for the dotted line, which is read as π/2, a vertical vibration)"
)


def _by_frequency(label: str, what: str, **rest: Any) -> FigureSpec:
    return panel(
        label,
        "frequency",
        kind="belt_profiles",
        title=f"{what} above the belt for several frequencies",
        where=USUAL | {"frequency": (10, 20, 60, 80)},
        named=_NAMED,
        **rest,
    )


def _by_angle(label: str, what: str, **rest: Any) -> FigureSpec:
    return panel(
        label,
        "vibration_angle",
        kind="belt_profiles",
        title=f"{what} above the belt for several angles of vibration",
        where=USUAL | {"frequency": 60, "vibration_angle": (30, 45, 60, 90)},
        named=_NAMED,
        **rest,
    )


def _by_damping(label: str, what: str, curves: str, **rest: Any) -> FigureSpec:
    return panel(
        label,
        "shear_damping",
        curves,
        kind="belt_profiles",
        title=f"{what} above the belt for several damping coefficients",
        **rest,
    )


_DENSITY = (
    "Local number density ρ of the beads, in beads per ⟨d⟩², over the height z above the belt in "
    "mean diameters ⟨d⟩, for several"
)
_VELOCITY = (
    "Mean horizontal velocity v_x of the beads over their height z above the belt in mean "
    "diameters ⟨d⟩, for several"
)
_OF_DENSITY, _OF_VELOCITY = {"quantity": "number_density"}, {"quantity": "velocity_profile"}
_AT_80 = {**AT_45, "prior_frequency": 0, "obstacle": 0, "frequency": 80}

FIGS_2_AND_3 = (
    _by_frequency(
        "2a",
        "Number density",
        lead=f"{_DENSITY} frequencies f.",
        says=(
            "The paper: at low frequency the density has a plateau that ends almost abruptly near "
            "z = 9⟨d⟩; with frequency its maximum falls, the profile smears out and a gas-like "
            "tail appears above the bed; close to the belt the density is very small."
        ),
        options=_OF_DENSITY | _FREQUENCIES,
    ),
    _by_angle(
        "2b",
        "Number density",
        lead=f"{_DENSITY} angles α of the vibration {_READ_AS}.",
        says=(
            "The paper: the curves of all angles collapse within their statistical errors, as the "
            "vertical vibration alone determines the density."
        ),
        options=_OF_DENSITY | _ANGLES,
    ),
    _by_damping(
        "2c",
        "Number density",
        "damping",
        where={**AT_45, "initial_velocity": 0, **_AT_80},
        lead=f"{_DENSITY} damping coefficients (γ, γ_s).",
        named=_NAMED,
        says=(
            "The paper: with less friction the layer is more smeared out; only very close to the "
            "belt the profiles do not depend on friction."
        ),
        options=_OF_DENSITY | _DAMPINGS,
    ),
    _by_frequency(
        "3a",
        "Horizontal velocity",
        lead=f"{_VELOCITY} frequencies f.",
        says=(
            "The paper: almost all beads move at the same speed, a plateau that grows with "
            "frequency; the velocity is smaller right at the belt and at great heights, where a "
            "steady state may not have been reached."
        ),
        options=_OF_VELOCITY | _FREQUENCIES,
    ),
    _by_angle(
        "3b",
        "Horizontal velocity",
        lead=f"{_VELOCITY} angles α of the vibration {_READ_AS}.",
        says="The paper: the plateau is higher the smaller the angle of vibration.",
        options=_OF_VELOCITY | _ANGLES,
    ),
    _by_damping(
        "3c",
        "Horizontal velocity",
        "damping initial_velocity",
        where=_AT_80,
        lead=(
            f"{_VELOCITY} damping coefficients (γ, γ_s); fast start, dashed: all beads begin with "
            "a higher speed than they end up with."
        ),
        named=(*_NAMED, "initial_velocity"),
        says=(
            "The paper: from γ_s = 50g on the profile depends only weakly on γ_s; the fall at "
            "great heights is unfinished relaxation and disappears after a start at a higher speed "
            "(dashed)."
        ),
        options=_OF_VELOCITY
        | _DAMPINGS
        | {"keys": ("damping", "shear_damping", "initial_velocity")},
    ),
)
