"""Judges of Gallas' claims about velocity and agitation over height, and about density waves."""

from itertools import pairwise

import numpy as np
from uncertainties import UFloat

from sim.claims.bed import beads_between, mean_between
from sim.claims.checks import above, below, within
from sim.claims.evidence import Evidence
from sim.claims.lines import along
from sim.claims.place import Place, joined
from sim.claims.trends import mean_of_others
from sim.claims.verdict import Check, Untestable

PROFILES = ("velocity_profile", "number_density")

#: Shares of the beads, from below, that are the middle of the bed and its two ends.
MIDDLE, LOWEST, HIGHEST = (0.2, 0.8), (0.0, 0.05), (0.95, 1.0)

#: Two of ten layers at the top, and two in the middle.
TOP_LAYERS, MIDDLE_LAYERS = (0.8, 1.0), (0.4, 0.6)


def mean_velocity(place: Place, shares: tuple[float, float]) -> UFloat:
    """Return the mean velocity (m/s) of the beads between two shares of them."""
    return place.measure(
        lambda _, velocity, number: mean_between(velocity, number, *shares), *PROFILES
    )


def relative_velocity(place: Place, shares: tuple[float, float]) -> UFloat:
    """Return the mean velocity of the beads between two shares over that of the middle."""

    def measure(_: np.ndarray, velocity: np.ndarray, number: np.ndarray) -> float:
        middle = mean_between(velocity, number, *MIDDLE)
        return mean_between(velocity, number, *shares) / middle

    return place.measure(measure, *PROFILES)


def g21(evidence: Evidence) -> list[Check]:
    """Slices in the middle 60 % of the beads differ by less than 10 %; both ends are slower."""
    checks = []
    for frequency, place in along(evidence, "frequency", (20, 60, 80)).items():
        at = f"{frequency} Hz"
        checks.append(below(f"spread of v_x in the middle, {at}", plateau(place), 0.1, (place,)))
        for end, shares in (("lowest", LOWEST), ("highest", HIGHEST)):
            what = f"v_x of the {end} 5 % of the beads over the middle, {at}"
            checks.append(below(what, relative_velocity(place, shares), 1, (place,)))
    return checks


def plateau(place: Place) -> UFloat:
    """Return the spread of the velocity over the slices of the middle, relative to their mean.

    Which slices are fastest and slowest is told by all other beds, see `mean_of_others`.
    """
    (velocity, _), (number, _) = (place.profile(name) for name in PROFILES)
    middle = beads_between(number.mean(axis=0), *MIDDLE) > 0
    relative = velocity[:, middle] / velocity[:, middle].mean(axis=1, keepdims=True)
    others, beds = mean_of_others(relative), np.arange(len(relative))
    return joined(relative[beds, others.argmax(axis=1)] - relative[beds, others.argmin(axis=1)])


def g22(evidence: Evidence) -> list[Check]:
    """Started fast, the highest 5 % of the beads differ from the middle by less than 5 %.

    Started at rest, they lag less in the longer runs of the converged protocol than in published
    ones. Both at 80 Hz, with the damping of Fig. 3c's dashed line and with the usual one.
    """
    checks = []
    for damping in (10, 50):
        where = {"frequency": 80, "damping": damping, "shear_damping": damping}
        fast = started_fast(evidence, **where)
        what = f"lag of the highest 5 % of the beads at γ = γ_s = {damping}g"
        checks.append(within(f"{what}, started fast", lag(fast), -0.05, 0.05, (fast,)))
        short, long = (
            evidence.at("belt", **where, initial_velocity=0, protocol=protocol)
            for protocol in ("published", "converged")
        )
        gain = lag(short) - lag(long)
        checks.append(above(f"{what}, published less converged", gain, 0, (short, long)))
    return checks


def started_fast(evidence: Evidence, **where: float) -> Place:
    """Return the place whose beads were started fastest, faster than they are in the end."""
    line = evidence.line("belt", "initial_velocity", **where)
    for start, place in reversed(line.items()):
        if start * np.sqrt(place["gravity"] * place["diameter"]) > place.velocity.nominal_value:
            return place
    raise Untestable(f"no run started faster than it ends, at {where}")


def lag(place: Place) -> UFloat:
    """Return by how much the highest 5 % of the beads are slower than the middle, relative."""
    return 1 - relative_velocity(place, HIGHEST)


def g23(evidence: Evidence) -> list[Check]:
    """The velocity of the middle rises over 10, 20, 60, 80 Hz and falls over 30 to 90 degrees."""
    lines = (
        ("Hz", 1, along(evidence, "frequency", (10, 20, 60, 80))),
        ("degrees, 60 Hz", -1, along(evidence, "vibration_angle", (30, 45, 60, 90), frequency=60)),
    )
    checks = []
    for unit, sign, line in lines:
        for (low, first), (high, second) in pairwise(line.items()):
            change = sign * (mean_velocity(second, MIDDLE) - mean_velocity(first, MIDDLE))
            what = (
                f"v_x of the middle {'gained' if sign > 0 else 'lost'} from {low} to {high} {unit}"
            )
            checks.append(above(what, change, 0, (first, second), "m/s"))
    return checks


def g29(evidence: Evidence) -> list[Check]:
    """Just above the onset the two top layers are twice as agitated as two in the middle."""
    names = "granular_temperature_profile", "number_density"

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
        for frequency, place in along(evidence, "frequency", (18, 20)).items()
    ]


def g30(evidence: Evidence) -> list[Check]:
    """Long density waves carry more power in the first 10 cycles than in the averaging window.

    At 40 Hz, with the parameters of Fig. 5b and with the usual ones.
    """
    places = (
        evidence.at("belt", frequency=40, vibration_angle=30, damping=10, shear_damping=10),
        evidence.at("belt", frequency=40),
    )
    checks = []
    for place in places:
        at = f"γ = γ_s = {place['damping']:g}g"
        power = place.value("wave_power")
        gain = place.value("early_wave_power") - power
        what = f"power of density waves, first 10 cycles less steady, {at}"
        checks.append(above(what, gain, 0, (place,)))
    return checks
