"""Judges of Gallas' claims about velocity and agitation over height, and about density waves."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from uncertainties import UFloat

from sim.claims.bed import beads_between, mean_between
from sim.claims.checks import above, below, judge_parts, remove_votes, within
from sim.claims.evidence import Evidence
from sim.claims.inference import trend
from sim.claims.lines import complete_line
from sim.claims.place import Place, replicate_mean
from sim.claims.trends import mean_of_others
from sim.claims.verdict import Check, Untestable

PROFILES = ("velocity_profile", "number_density")

#: Cumulative shares of the beads, from below, of the middle of the bed and its two ends.
MIDDLE, LOWEST, HIGHEST = (0.2, 0.8), (0.0, 0.05), (0.95, 1.0)

#: Damping (g) of the dashed line of Fig. 3c, at which beds take longest to relax.
RELAXING = {"damping": 10, "shear_damping": 10}

#: Angles of vibration (degrees) of Fig. 3b.
ANGLES = (30, 45, 60, 90)

#: Two of ten layers at the top, and two in the middle.
TOP_LAYERS, MIDDLE_LAYERS = (0.8, 1.0), (0.4, 0.6)


def relative_velocity(place: Place, shares: tuple[float, float]) -> UFloat:
    """Return the mean velocity of the beads between two shares over that of the middle."""

    def measure(_: np.ndarray, velocity: np.ndarray, number: np.ndarray) -> float:
        middle = mean_between(velocity, number, *MIDDLE)
        return mean_between(velocity, number, *shares) / middle

    return place.measure(measure, *PROFILES)


def g21(evidence: Evidence) -> list[Check]:
    """A plateau (a), slower beads at the belt (b), and at the top in runs not yet relaxed (c)."""
    line = complete_line(evidence, "frequency", (20, 60, 80))
    return judge_parts(
        a=lambda: [
            below(f"spread of v_x in the middle, {f} Hz", plateau(place), 0.1, (place,))
            for f, place in line.items()
        ],
        b=lambda: [
            below(_end_label(f, "lowest"), relative_velocity(place, LOWEST), 1, (place,))
            for f, place in line.items()
        ],
        c=lambda: _check_top_lag(evidence),
    )


def _end_label(frequency: float, end: str) -> str:
    return f"v_x of the {end} 5 % of the beads over the middle, {frequency} Hz"


def _check_top_lag(evidence: Evidence) -> list[Check]:
    """Check the paper's case without relaxation: 80 Hz with 10g, runs of the published length."""
    place = evidence.at("belt", frequency=80, **RELAXING, protocol="published", initial_velocity=0)
    quantity = f"{_end_label(80, 'highest')}, γ = γ_s = 10g, published lengths"
    return [below(quantity, relative_velocity(place, HIGHEST), 1, (place,))]


def plateau(place: Place) -> UFloat:
    """Return the spread of the velocity over the slices of the middle, relative to their mean.

    All other beds select the fastest and the slowest slice, see `mean_of_others`.
    """
    (velocity, _), (number, _) = (place.profile(name) for name in PROFILES)
    middle = beads_between(number.mean(axis=0), *MIDDLE) > 0
    relative = velocity[:, middle] / velocity[:, middle].mean(axis=1, keepdims=True)
    others, beds = mean_of_others(relative), np.arange(len(relative))
    return replicate_mean(
        relative[beds, others.argmax(axis=1)] - relative[beds, others.argmin(axis=1)]
    )


def g22(evidence: Evidence) -> list[Check]:
    """Started fast, the highest 5 % of the beads differ from the middle by less than 5 %.

    Started at rest, they lag less in the longer runs of the converged protocol than in published
    ones. The case is 80 Hz with the damping of the dashed line in Fig. 3c; the usual damping is
    reported.
    """
    checks = []
    for damping in (10, 50):
        where = {"frequency": 80, "damping": damping, "shear_damping": damping}
        try:
            relaxation = _check_relaxation(evidence, damping, where)
        except Untestable:
            if damping == 10:
                raise
            continue
        checks += relaxation if damping == 10 else remove_votes(relaxation)
    return checks


def _check_relaxation(evidence: Evidence, damping: float, where: dict[str, int]) -> list[Check]:
    fast = fastest_start(evidence, **where)
    quantity = f"lag of the highest 5 % of the beads at γ = γ_s = {damping}g"
    short, long = (
        evidence.at("belt", **where, initial_velocity=0, protocol=protocol)
        for protocol in ("published", "converged")
    )
    gain = lag(short) - lag(long)
    return [
        within(f"{quantity}, started fast", lag(fast), -0.05, 0.05, (fast,)),
        above(f"{quantity}, published less converged", gain, 0, (short, long)),
    ]


def fastest_start(evidence: Evidence, **where: float) -> Place:
    """Return the place with the fastest start that exceeds the final velocity.

    Raises `Untestable` if there is none.
    """
    line = evidence.line("belt", "initial_velocity", **where)
    for start, place in reversed(line.items()):
        if start * np.sqrt(place["gravity"] * place["diameter"]) > place.velocity.nominal_value:
            return place
    raise Untestable(f"no run started faster than it ends, at {where}")


def lag(place: Place) -> UFloat:
    """Return the relative lag of the highest 5 % of the beads behind the middle."""
    return 1 - relative_velocity(place, HIGHEST)


def g23(evidence: Evidence) -> list[Check]:
    """The velocity of the middle rises over 10, 20, 60, 80 Hz and falls over 30 to 90 degrees."""
    lines = (
        ("f (Hz)", True, complete_line(evidence, "frequency", (10, 20, 60, 80))),
        (
            "α (degrees), 60 Hz,",
            False,
            complete_line(evidence, "vibration_angle", ANGLES, frequency=60),
        ),
    )
    checks = []
    for name, is_rising, line in lines:
        groups = [place.measure_replicates(middle_velocity, *PROFILES) for place in line.values()]
        values = ", ".join(f"{value:g}" for value in line)
        quantity = f"v_x of the middle over {name} = {values}"
        checks.append(trend(quantity, [groups], line.values(), rising=is_rising))
    return checks


def middle_velocity(_: np.ndarray, velocity: np.ndarray, number: np.ndarray) -> float:
    """Return the mean velocity (m/s) of the beads in the middle of the bed."""
    return mean_between(velocity, number, *MIDDLE)


def g29(evidence: Evidence) -> list[Check]:
    """Just above the onset the two top layers are twice as agitated as two in the middle.

    The temperature is taken about the mean motion at each phase of the cycle.
    """
    names = "fluctuation_temperature_profile", "number_density"

    def measure(_: np.ndarray, temperature: np.ndarray, number: np.ndarray) -> float:
        top, middle = (
            mean_between(temperature, number, *shares) for shares in (TOP_LAYERS, MIDDLE_LAYERS)
        )
        return top / middle

    return [
        above(
            f"granular temperature of the top two layers over the middle, {frequency} Hz",
            place.measure(measure, *names),
            2,
            (place,),
        )
        for frequency, place in complete_line(evidence, "frequency", (18, 20)).items()
    ]


def g30(evidence: Evidence) -> list[Check]:
    """Long density waves carry more power in the first 10 cycles than in the averaging window.

    At 40 Hz, with the parameters of Fig. 5b and with the usual ones.
    """
    settings: tuple[dict[str, Any], ...] = (
        {"frequency": 40, "vibration_angle": 30, "damping": 10, "shear_damping": 10},
        {"frequency": 40},
    )
    checks = []
    for where in settings:
        place = evidence.at("belt", **where)
        early, places = early_wave_power(evidence, place, where)
        gain = early - place.value("wave_power")
        label = f"γ = γ_s = {place['damping']:g}g"
        quantity = f"power of density waves, first 10 cycles less steady, {label}"
        checks.append(above(quantity, gain, 0, places))
    return checks


def early_wave_power(
    evidence: Evidence, place: Place, where: Mapping[str, Any]
) -> tuple[UFloat, list[Place]]:
    """Return the power of density waves in the first 10 cycles, and the places of the beds.

    The protocol sets how long a bed runs, not how it begins. So beds of the published protocol that
    the converged one lacks count as well.
    """
    places = [place]
    with suppress(Untestable):
        published = evidence.at("belt", protocol="published", **where)
        if published.id != place.id and published["seed"] == place["seed"]:
            places.append(published)
    powers: dict[int, float] = {}
    for source in reversed(places):
        powers |= zip(
            source.values("replicate_seed"), source.values("early_wave_power"), strict=True
        )
    return replicate_mean(np.array([*powers.values()])), places
