"""Judges of Gallas' claims about where the beads are: their density over height."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import inf, nan

import numpy as np
from uncertainties import UFloat

from sim.base.statistics import student
from sim.claims.bed import half_height, layer_width, peak, spread
from sim.claims.checks import above, below, within
from sim.claims.evidence import Evidence
from sim.claims.lines import FLOWING, along, common_beds, replicated
from sim.claims.place import Place, joined, measured
from sim.claims.trends import mean_of_others
from sim.claims.verdict import Check, Untestable

DENSITY = "number_density"

#: Frequencies (Hz) of Fig. 2a.
FREQUENCIES = (10, 20, 60, 80)


def g15(evidence: Evidence) -> list[Check]:
    """At 10 Hz each slice from 2 to 8 ⟨d⟩ is within 10 % of their mean.

    The density falls to half at 9 ± 1 ⟨d⟩, and no bead is missing.
    """
    place = evidence.at("belt", frequency=10)
    diameter = place["diameter"]
    density, height = place.profile(DENSITY)
    inside = (height > 2 * diameter) & (height < 8 * diameter)
    plateau = density[:, inside]
    off = plateau / plateau.mean(axis=1, keepdims=True) - 1
    top = place.measure(half_height, DENSITY) / diameter
    beads = place.measure(lambda height, number: number.sum() * (height[1] - height[0]), DENSITY)
    expected = place["beads"] / (place["width"] * diameter)
    slices = [
        within(
            f"deviation of ρ from its plateau at {at / diameter:g}⟨d⟩",
            joined(column),
            -0.1,
            0.1,
            (place,),
        )
        for at, column in zip(height[inside], off.T, strict=True)
    ]
    return [
        *slices,
        within("height at which ρ is half of its plateau", top, 8, 10, (place,), "⟨d⟩"),
        within("∫ρ dz over N/L", beads / expected, 0.99, 1.01, (place,)),
    ]


def g16(evidence: Evidence) -> list[Check]:
    """The lowest slice has less than 30 % of the largest density, at all frequencies with flow."""
    line = replicated(evidence.line("belt", "frequency"))
    flowing = {frequency: place for frequency, place in line.items() if frequency >= FLOWING}
    if not set(FREQUENCIES[1:]) <= set(flowing):
        raise Untestable("no runs at 20, 60 and 80 Hz with several beds")
    return [
        below(
            f"ρ of the lowest slice over the largest, {frequency:g} Hz",
            place.measure(lambda height, number: number[0] / number.max(), DENSITY),
            0.3,
            (place,),
        )
        for frequency, place in flowing.items()
    ]


def g17(evidence: Evidence) -> list[Check]:
    """From 10 to 20, 60 and 80 Hz the largest density falls and the layer widens."""
    line = along(evidence, "frequency", FREQUENCIES)
    checks = []
    for (low, first), (high, second) in pairwise(line.items()):
        places, step = (first, second), f"from {low} to {high} Hz"
        lost = first.measure(peak, DENSITY) - second.measure(peak, DENSITY)
        checks.append(above(f"ρ_max lost {step}", lost, 0, places, "m-2"))
        checks += wider(second, first, f"gained {step}")
    return checks


def wider(one: Place, other: Place, how: str) -> list[Check]:
    """Return the check that the layer is wider at one place than at another.

    The standard deviation of all heights, which few beads high above can dominate, is reported.
    """
    checks = []
    for what, measure, least in (
        ("width of the layer", layer_width, 0),
        ("standard deviation of the heights", spread, -inf),
    ):
        gain = (one.measure(measure, DENSITY) - other.measure(measure, DENSITY)) / one["diameter"]
        checks.append(above(f"{what} {how}", gain, least, (one, other), "⟨d⟩"))
    return checks


def g18(evidence: Evidence) -> list[Check]:
    """Above 1.5 times the height of the bed at 10 Hz there are beads at 60 and 80 Hz, none at 10.

    The density compared is that of the first slice wholly above.
    """
    bed, *fluid = along(evidence, "frequency", (10, 60, 80)).values()
    top = 1.5 * bed.measure(half_height, DENSITY).nominal_value
    checks = []
    for place in (bed, *fluid):
        density = place.measure(_first_above(top), DENSITY) * place["diameter"] ** 2
        what = f"ρ⟨d⟩² above 1.5 bed heights, {place['frequency']:g} Hz"
        checks.append((below if place is bed else above)(what, density, 1e-3, (place,)))
    return checks


def _first_above(top: float) -> Callable[[np.ndarray, np.ndarray], float]:
    """Return the measure that is the density of the first slice wholly above a height (m)."""

    def measure(height: np.ndarray, number: np.ndarray) -> float:
        higher = np.flatnonzero(height - 0.5 * (height[1] - height[0]) >= top)
        return float(number[higher[0]]) if higher.size else nan

    return measure


def g19(evidence: Evidence) -> list[Check]:
    """Densities at four angles differ no more than beds do, χ²/dof < 1.5, and by less than 5 %.

    Slices with less than 1 % of the largest density are left out. The interval of χ²/dof comes from
    leaving out one bed after the other.
    """
    places = list(along(evidence, "vibration_angle", (30, 45, 60, 90), frequency=60).values())
    profiles = [place.profile(DENSITY)[0] for place in places]
    shared = common_beds(places)
    beds = len(shared[0])
    if beds < 3:
        raise Untestable("fewer than three beds that are known at 60 Hz and 30, 45, 60, 90 degrees")
    density = np.array([each[which] for each, which in zip(profiles, shared, strict=True)])
    mean = density.mean(axis=1)
    dense = mean.mean(axis=0) > 0.01 * mean.max()
    density = density[:, :, dense] / mean.max()
    rest = np.array([chi_squared(np.delete(density, bed, axis=1)) for bed in range(beds)])
    error = np.sqrt((beds - 1) / beds * ((rest - rest.mean()) ** 2).sum())
    statistic, half_width = chi_squared(density), student(beds - 1) * error
    return [
        below(
            "χ²/dof of the densities at 30, 45, 60 and 90°",
            measured(statistic, float(half_width)),
            1.5,
            places,
        ),
        below("largest difference of ρ over ρ_max", largest_difference(density), 0.05, places),
    ]


def chi_squared(density: np.ndarray) -> float:
    """Return χ²/dof of mean densities (A, R, S) at A angles, with the scatter of R beds as errors.

    The sizes of a bed's beads are the same at all angles, so what a bed has more than others at all
    of them does not count as scatter. That errors come from few beds is corrected for.
    """
    angles, beds, _ = density.shape
    freedom = (angles - 1) * (beds - 1)
    mean = density.mean(axis=1, keepdims=True)
    scatter = density - mean
    scatter = scatter - scatter.mean(axis=0)
    error = (scatter**2).sum(axis=(0, 1)) / freedom / beds
    between = mean[:, 0].var(axis=0, ddof=1)
    known = error > 0
    return float((between[known] / error[known]).mean() * (freedom - 2) / freedom)


def largest_difference(density: np.ndarray) -> UFloat:
    """Return the largest difference of mean densities (A, R, S) between two angles in a slice.

    Which angles and slice differ most is told by all beds but one, and by how much by that one, for
    each of them in turn. So chance, which makes the largest of many differences, adds nothing, and
    the sizes of a bed's beads, which are the same at all angles, do not count as scatter.
    """
    differences = []
    for bed, mean in enumerate(mean_of_others(density, axis=1).swapaxes(0, 1)):
        at = int(np.ptp(mean, axis=0).argmax())
        high, low = int(mean[:, at].argmax()), int(mean[:, at].argmin())
        differences.append(density[high, bed, at] - density[low, bed, at])
    return joined(np.array(differences))


def g20(evidence: Evidence) -> list[Check]:
    """At 80 Hz less friction widens the layer; below 2⟨d⟩ its beads stay within 10 %."""
    pairs = ((10, 10), (0, 50), (50, 50), (50, 100))
    found = {
        pair: evidence.at("belt", frequency=80, damping=pair[0], shear_damping=pair[1])
        for pair in pairs
    }
    checks = []
    for less, more in (((10, 10), (50, 50)), ((10, 10), (50, 100)), ((0, 50), (50, 100))):
        checks += wider(found[less], found[more], f"at {_pair(less)} less {_pair(more)}")
    firm = found[50, 100]
    for pair in pairs[:2]:
        change = near_belt(found[pair]) / near_belt(firm) - 1
        what = f"beads below 2⟨d⟩ at {_pair(pair)} over {_pair((50, 100))}, less 1"
        checks.append(within(what, change, -0.1, 0.1, (found[pair], firm)))
    return checks


def near_belt(place: Place) -> UFloat:
    """Return the number of beads per area (m⁻²) in the slices below 2⟨d⟩."""
    top = 2 * place["diameter"]
    return place.measure(lambda height, number: number[height < top].mean(), DENSITY)


def _pair(pair: Sequence[float]) -> str:
    return "({:g}g, {:g}g)".format(*pair)
