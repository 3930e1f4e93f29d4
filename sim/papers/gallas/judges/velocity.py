"""Judges of Gallas' claims about velocity and agitation over height, and about density waves."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import Numbers, Pair, above, below, judge_parts, remove_votes, within
from sim.claims.evidence import Evidence
from sim.claims.inference import mean_of_others, reported_order, trend
from sim.claims.place import Place, replicate_mean
from sim.claims.verdict import Check, Untestable
from sim.measures.belt import EARLY_CYCLES
from sim.papers.gallas.judges.lines import beads_between, complete_line, mean_between, pair_label

PROFILES = ("velocity_profile", "number_density")

#: Share of the beads in the middle of the bed, where a claim gives none.
MIDDLE = 0.6

#: Damping (g) at which the lag of the highest beads is reported.
USUAL_DAMPING = 50

#: Two of ten layers at the top, and two in the middle.
TOP_LAYERS, MIDDLE_LAYERS = (0.8, 1.0), (0.4, 0.6)


def relative_velocity(place: Place, shares: Pair, middle: float) -> UFloat:
    """Return the mean velocity of the beads between two shares over that of the middle."""

    def measure(_: np.ndarray, velocity: np.ndarray, number: np.ndarray) -> float:
        usual = mean_between(velocity, number, *middle_shares(middle))
        return mean_between(velocity, number, *shares) / usual

    return place.measure(measure, *PROFILES)


def middle_shares(middle: float) -> Pair:
    """Return the cumulative shares of the beads, from below, between which the middle lies."""
    return 0.5 - 0.5 * middle, 0.5 + 0.5 * middle


def g21(
    evidence: Evidence,
    *,
    frequencies: Numbers,
    angles: Numbers,
    angled: float,
    pairs: Sequence[Pair],
    damped: float,
    middle: float,
    max_spread: float,
    end: float,
) -> list[Check]:
    """A plateau (a), slower beads at the belt (b), and at the top in runs not yet relaxed (c).

    The curves are those of Fig. 3: of frequencies (Hz), of angles (degrees) at the one ``angled``,
    and of pairs of damping and shear damping (g) at the one ``damped``. ``middle`` and ``end`` are
    shares of the beads.
    """
    curves: list[dict[str, Any]] = [
        *({"frequency": f} for f in frequencies),
        *({"frequency": angled, "vibration_angle": angle} for angle in angles),
        *({"frequency": damped, "damping": g, "shear_damping": shear} for g, shear in pairs),
    ]

    def places(**rest: Any) -> list[Place]:
        return [evidence.at("belt", initial_velocity=0, **curve, **rest) for curve in curves]

    def plateaus() -> list[Check]:
        return [
            below(
                f"spread of v_x in the middle, {_curve_label(place)}",
                plateau(place, middle),
                max_spread,
                [place],
            )
            for place in places()
        ]

    def slower(name: str, shares: Pair, found: list[Place]) -> list[Check]:
        quantity = f"v_x of the {name} {100 * end:g} % of the beads over the middle"
        return [
            below(
                f"{quantity}, {_curve_label(place)}",
                relative_velocity(place, shares, middle),
                1,
                [place],
            )
            for place in found
        ]

    return judge_parts(
        a=plateaus,
        b=lambda: slower("lowest", (0, end), places()),
        c=lambda: slower("highest", (1 - end, 1), places(protocol="published")),
    )


def _curve_label(place: Place) -> str:
    pair = pair_label(place["damping"], place["shear_damping"])
    return f"{place['frequency']:g} Hz, {place['vibration_angle']:g}°, {pair}"


def plateau(place: Place, share: float) -> UFloat:
    """Return the spread of the velocity over the slices of the middle, relative to their mean.

    ``share`` is that of the beads in the middle. All other beds select the fastest and the slowest
    slice, see `mean_of_others`.
    """
    (velocity, _), (number, _) = (place.profile(name) for name in PROFILES)
    middle = beads_between(number.mean(axis=0), *middle_shares(share)) > 0
    relative = velocity[:, middle] / velocity[:, middle].mean(axis=1, keepdims=True)
    others, beds = mean_of_others(relative), np.arange(len(relative))
    return replicate_mean(
        relative[beds, others.argmax(axis=1)] - relative[beds, others.argmin(axis=1)]
    )


def g22(
    evidence: Evidence, *, frequency: float, damping: float, end: float, max_lag: float
) -> list[Check]:
    """Started fast, the highest beads differ from the middle by less than ``max_lag``.

    ``end`` is their share of the beads. The damping is in g; the usual one is reported.
    """
    where = {"frequency": frequency, "damping": damping, "shear_damping": damping}
    checks = _check_relaxation(evidence, end, max_lag, where)
    with suppress(Untestable):
        usual = where | {"damping": USUAL_DAMPING, "shear_damping": USUAL_DAMPING}
        checks += remove_votes(_check_relaxation(evidence, end, max_lag, usual))
    return checks


def _check_relaxation(
    evidence: Evidence, end: float, max_lag: float, where: dict[str, float]
) -> list[Check]:
    fast = fastest_start(evidence, **where)
    quantity = f"lag of the highest {100 * end:g} % of the beads at γ = γ_s = {where['damping']}g"
    short, long = (
        evidence.at("belt", **where, initial_velocity=0, protocol=protocol)
        for protocol in ("published", "converged")
    )
    gain = lag(short, end) - lag(long, end)
    return [
        within(f"{quantity}, started fast", lag(fast, end), -max_lag, max_lag, (fast,)),
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


def lag(place: Place, end: float) -> UFloat:
    """Return the relative lag of the highest beads, a share of them, behind the middle."""
    return 1 - relative_velocity(place, (1 - end, 1), MIDDLE)


def g23(evidence: Evidence, *, middle: float, frequencies: Numbers, angles: Numbers) -> list[Check]:
    """The velocity of the middle rises over the frequencies (Hz) and falls over the angles."""
    lines = (
        ("f (Hz)", True, complete_line(evidence, "frequency", frequencies)),
        (
            "α (degrees), 60 Hz,",
            False,
            complete_line(evidence, "vibration_angle", angles, frequency=60),
        ),
    )

    def middle_velocity(_: np.ndarray, velocity: np.ndarray, number: np.ndarray) -> float:
        return mean_between(velocity, number, *middle_shares(middle))

    checks = []
    for name, is_rising, line in lines:
        groups = [place.measure_replicates(middle_velocity, *PROFILES) for place in line.values()]
        values = ", ".join(f"{value:g}" for value in line)
        quantity = f"v_x of the middle over {name} = {values}"
        checks.append(trend(quantity, [groups], line.values(), rising=is_rising))
        order = f"v_x of the middle {'rises' if is_rising else 'falls'} over {name.rstrip(',')}"
        checks.append(reported_order(order, [groups], rising=is_rising))
    return checks


def g29(evidence: Evidence, *, min_ratio: float, frequencies: Numbers) -> list[Check]:
    """The two top layers are ``min_ratio`` times as agitated as two in the middle.

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
            min_ratio,
            (place,),
        )
        for frequency, place in complete_line(evidence, "frequency", frequencies).items()
    ]


def g30(evidence: Evidence, *, frequency: float, angle: float, damping: Numbers) -> list[Check]:
    """Long density waves carry more power in the first cycles than in the averaging window.

    This is tested at one frequency (Hz), with the ``angle`` (degrees) and the ``damping`` (g) of
    Fig. 5b (a), and with the usual angle and a second damping (b).
    """
    settings: tuple[dict[str, Any], ...] = (
        {"vibration_angle": angle, "damping": damping[0], "shear_damping": damping[0]},
        {"damping": damping[1], "shear_damping": damping[1]},
    )
    checks = []
    for part, setting in zip("ab", settings, strict=True):
        where = {"frequency": frequency, **setting}
        place = evidence.at("belt", **where)
        early, places = early_wave_power(evidence, place, where)
        gain = early - place.value("wave_power")
        label = f"γ = γ_s = {place['damping']:g}g"
        quantity = f"power of density waves, first {EARLY_CYCLES} cycles less steady, {label}"
        checks.append(replace(above(quantity, gain, 0, places), part=part))
    return checks


def early_wave_power(
    evidence: Evidence, place: Place, where: Mapping[str, Any]
) -> tuple[UFloat, list[Place]]:
    """Return the power of density waves in the first cycles, and the places of the beds.

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
