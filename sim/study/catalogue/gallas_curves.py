"""Gallas' Figs. 1 and 6, and what the paper describes of the flow over a parameter."""

from typing import Any

from sim.study.catalogue.gallas import (
    AT_45,
    BED,
    BLACK,
    BLUE,
    DAMPED,
    FLOW,
    FROM_REST,
    GREEN,
    ORANGE,
    PINK,
    RED,
    WINDOW,
    figure,
    panel,
    usual_without,
)
from sim.study.catalogue.spec import FigureSpec

#: Wherever amplitudes are told apart.
_AMPLITUDES = {
    1.5: (RED, "dash_dot", "o"),
    1.0: (BLACK, "solid", "o"),
    0.5: (BLUE, "short_dash", "o"),
}

_FREQUENCY = "f = {frequency:g} Hz"
_AGAINST_FRICTION = {
    "styles": {50.0: (BLACK, "solid", "o"), 20.0: (BLUE, "long_dash", "s")},
    "entry": _FREQUENCY,
}
_RISES = "The paper: the flux rises rapidly up to γ_s = 10g and only gently from there on."

FIG_1 = (
    panel(
        "1a",
        "frequency",
        "vibration_angle",
        kind="belt_curves",
        title="Transport velocity against frequency for three angles of vibration",
        lead=(
            "Transport velocity V_x of the beads against the frequency f of the belt, "
            "for several angles α of the vibration."
        ),
        named=FLOW,
        says=(
            "The paper: after a rather rapid jump near 16 Hz, at the same frequency for all "
            "angles, the flux grows monotonically and in the end linearly; flatter vibrations "
            "transport faster."
        ),
        options={
            "styles": {
                60.0: (RED, "dash_dot", "^"),
                45.0: (BLACK, "solid", "o"),
                30.0: (BLUE, "short_dash", "s"),
            },
            "entry": "α = {vibration_angle:g}°",
            "entries": {60.0: "α = π/3", 45.0: "α = π/4", 30.0: "α = π/6"},
        },
    ),
    panel(
        "1b",
        "frequency",
        "amplitude damping shear_damping",
        kind="belt_curves",
        title="Transport velocity against frequency for amplitudes and damping coefficients",
        where=FROM_REST,
        lead=(
            "Transport velocity V_x of the beads against the frequency f of the belt: lines for "
            "several amplitudes A_z of the vibration at γ = γ_s = 50g, markers alone for other "
            "damping coefficients (γ, γ_s)."
        ),
        named=FLOW,
        says=(
            "The paper: all curves jump up and then grow monotonically; beads start to flow at "
            "about 16 Hz for amplitudes of 1 and 1.5 ⟨d⟩, at about 18 Hz for half a diameter, "
            "whatever the damping."
        ),
        options={
            "look": "amplitude_or_damping",
            "styles": _AMPLITUDES,
            "markers": {
                (0.0, 50.0): (GREEN, "none", "^"),
                (10.0, 10.0): (PINK, "none", "X"),
                (50.0, 100.0): (ORANGE, "none", "s"),
            },
        },
    ),
    panel(
        "1c",
        "shear_damping",
        "frequency",
        kind="belt_curves",
        title="Transport velocity against the shear friction coefficient",
        lead=(
            "Transport velocity V_x of the beads against the shear friction coefficient γ_s, "
            "for several frequencies f of the belt."
        ),
        named=FLOW,
        says=_RISES,
        options=_AGAINST_FRICTION,
    ),
)

FIG_6 = panel(
    "6",
    "obstacle",
    "frequency",
    kind="belt_curves",
    title="Transport velocity against the diameter of an obstacle",
    where={"frequency": (20, 80), **AT_45, **FROM_REST, **DAMPED},
    lead=(
        "Transport velocity V_x of the beads against the diameter d_o of a fixed circular obstacle "
        "in the middle of the cell at the height A_z above the average belt, for several "
        "frequencies f."
    ),
    named=("frequency", *FLOW),
    says="The paper: even a rather small obstacle rapidly slows down the flow.",
    options={
        "styles": {80.0: (BLACK, "solid", "o"), 20.0: (BLUE, "long_dash", "s")},
        "entry": _FREQUENCY,
    },
)


def _described(
    name: str,
    place: str,
    axes: str,
    curves: str = "",
    where: dict[str, Any] | None = None,
    **rest: Any,
) -> FigureSpec:
    """Return a figure that the paper describes but does not show."""
    usual = usual_without({*axes.split(), *curves.split()})
    return figure(name, place, axes, curves, where=usual | (where or {}), **rest)


DESCRIBED = (
    figure(
        "protocols_1c",
        "Fig. 1c, under both protocols",
        "shear_damping protocol",
        "frequency",
        kind="belt_curves",
        title="Transport velocity against the shear friction coefficient under both protocols",
        lead=(
            "Transport velocity V_x of the beads against the shear friction coefficient γ_s, for "
            "several frequencies f of the belt: left from runs of the published length, right from "
            "runs that go on until the mean velocity has converged. Where the panels differ, runs "
            "of the published length are too short."
        ),
        named=FLOW,
        says=_RISES,
        options=_AGAINST_FRICTION,
    ),
    _described(
        "onset_acceleration",
        "onset of the flow",
        "frequency",
        "amplitude vibration_angle",
        kind="belt_acceleration",
        title="Onset of transport against the acceleration of the belt",
        lead=(
            "Transport velocity V_x of the beads over that of the belt along x, A_x·2πf, against "
            "the largest acceleration of the belt, Γ = 4π²f²A_z/g, for several amplitudes A_z and "
            "angles α of the vibration, near the onset of transport. Dotted: Γ = 1, and 10 and "
            "2 %: the share from which on beads flow is open, 10 % unless the claim says another."
        ),
        named=("frequency", *FLOW),
        says=(
            "The paper: transport begins near 16 Hz whatever the angle, for A_z = ⟨d⟩ as for "
            "1.5 ⟨d⟩, and near 18 Hz for 0.5 ⟨d⟩; at A_z = ⟨d⟩ that is Γ ≈ 1. An onset at the same "
            "Γ for all amplitudes is one at frequencies in proportion to 1/√A_z."
        ),
        options={
            "entry": "$A_z$ = {amplitude:g} ⟨d⟩, α = {vibration_angle:g}°",
            "levels": (0.02, 0.1),
        },
    ),
    _described(
        "belt_void",
        "void at the belt",
        "frequency",
        "amplitude",
        kind="belt_measures",
        title="Share of the beads within the belt's reach against frequency",
        lead=(
            "Share of the beads whose centres are within the amplitude A_z of the mean position of "
            "the belt, against its frequency f, for several amplitudes. Dotted: 3 %, "
            "below which the claims call it a void."
        ),
        named=FLOW,
        says=(
            "The paper: above 60 Hz almost no bead is between the extreme positions of the belt."
        ),
        options={
            "axis": "share of the beads within the belt's reach",
            "levels": (0.03,),
            "quantities": (
                {"name": "base_occupancy", "label": "beads within the belt's reach [1]"},
            ),
            "styles": _AMPLITUDES,
            "entry": "$A_z$ = {amplitude:g} ⟨d⟩",
        },
    ),
    _described(
        "belt_stiffness",
        "stiffness of the beads",
        "stiffness",
        "frequency",
        where={"frequency": (20, 50, 80)},
        kind="belt_curves",
        title="Transport velocity against the stiffness of the beads",
        lead=(
            "Transport velocity V_x of the beads against their stiffness Y, in units of g⟨m⟩/⟨d⟩, "
            "for several frequencies f of the belt."
        ),
        named=("frequency", *FLOW),
        says="The paper: above Y = 500 g⟨m⟩/⟨d⟩ the stiffness has only a weak influence.",
        options={
            "scale": "log",
            "styles": {
                80.0: (BLACK, "solid", "o"),
                50.0: (RED, "short_dash", "^"),
                20.0: (BLUE, "long_dash", "s"),
            },
            "entry": _FREQUENCY,
        },
    ),
    _described(
        "density_waves",
        "density waves",
        "frequency",
        kind="belt_measures",
        title="Density waves right after the start and later against frequency",
        lead=(
            "Power of the five longest waves of the density along the belt, 1 for beads at random "
            "places, against the frequency f: over the first 10 cycles from rest, and over the "
            "averaging window."
        ),
        named=FLOW,
        says=(
            "The paper: dense regions move through the bed, more so right after the shaking starts."
        ),
        options={
            "axis": "power of long density waves",
            "quantities": (
                {
                    "name": "early_wave_power",
                    "label": "power in the first 10 cycles [1]",
                    "entry": "first 10 cycles",
                    "style": (BLUE, "long_dash", "s"),
                },
                {
                    "name": "wave_power",
                    "label": "power in the averaging window [1]",
                    "entry": "averaging window",
                    "style": (BLACK, "solid", "o"),
                },
            ),
        },
    ),
    figure(
        "belt_onset",
        "onset of the flow",
        "amplitude frequency",
        "vibration_angle",
        kind="belt_onset",
        title="Onset of transport against amplitude",
        lead=(
            "Frequency f at which transport begins on the vibrating belt against the vertical "
            "amplitude A_z: intervals found by refinement. Dotted: the acceleration of the belt "
            "reaches that of gravity, Γ = 4π²f²A_z/g = 1. Transport is where the 95 % interval of "
            "every bed's mean velocity lies above 10 % of the velocity amplitude of the belt along "
            "x, no transport where it lies below."
        ),
        named=(
            "vibration_angle",
            "damping",
            "shear_damping",
            *BED,
            "steps_per_cycle",
            *WINDOW,
        ),
        says=(
            "The paper: onset near 16 Hz for amplitudes of 1 and 1.5 ⟨d⟩, near 18 Hz for half a "
            "diameter; for one diameter that is Γ ≈ 1."
        ),
    ),
)
