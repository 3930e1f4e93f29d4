"""Judges of Gallas' claims about where the beads are: their density over height."""

from collections.abc import Callable, Sequence
from math import inf, nan, sqrt

import numpy as np
from scipy.optimize import curve_fit
from uncertainties import UFloat

from sim.claims.bed import half_height, layer_width, peak, spread
from sim.claims.checks import above, below, reported, within
from sim.claims.evidence import Evidence
from sim.claims.inference import trend
from sim.claims.lines import FLOWING, along, common_beds, replicated
from sim.claims.place import Place, joined, measured, quotient
from sim.claims.trends import mean_of_others
from sim.claims.verdict import SIGMAS, Check, Untestable

DENSITY = "number_density"

#: Frequencies (Hz) of Fig. 2a.
FREQUENCIES = (10, 20, 60, 80)


def g15(evidence: Evidence) -> list[Check]:
    """At 10 Hz each slice from 2 to 8 ⟨d⟩ is within 10 % of their mean, and the plateau ends at 9.

    It ends where a constant that falls off linearly to nothing begins to fall.
    """
    place = evidence.at("belt", frequency=10)
    diameter = place["diameter"]
    density, height = place.profile(DENSITY)
    inside = (height > 2 * diameter) & (height < 8 * diameter)
    plateau = density[:, inside]
    off = plateau / plateau.mean(axis=1, keepdims=True) - 1
    end = place.measure(plateau_end(diameter), DENSITY, grid="slices") / diameter
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
    thick = float(np.diff(place.profile(DENSITY, "slices")[1][:2])[0]) / diameter
    return [
        *slices,
        within(f"end of the plateau, slices of {thick:g}⟨d⟩", end, 8, 10, (place,), "⟨d⟩"),
        reported("height at which ρ is half of its plateau", top, (place,), "⟨d⟩"),
        reported("∫ρ dz over N/L", beads / expected, (place,)),
    ]


def plateau_end(diameter: float) -> Callable[[np.ndarray, np.ndarray], float]:
    """Return the measure that is the height (m) at which a plateau of the density ends.

    Least squares of a constant up to there and a straight fall to nothing above, with the mean over
    each slice; the lowest diameter (m), where beads lie on the belt, does not count.
    """

    def measure(height: np.ndarray, number: np.ndarray) -> float:
        slices, width = height[height > diameter], height[1] - height[0]
        fine = slices[:, None] + width * (np.arange(20) / 20 - 0.475)

        def profile(_: np.ndarray, level: float, end: float, fall: float) -> np.ndarray:
            return level * np.clip(1 - (fine - end) / fall, 0, 1).mean(axis=1)

        level = float(np.median(number[number > 0.5 * number.max()]))
        start = level, half_height(height, number) - 0.5 * diameter, diameter
        bounds = (0, 0, 0.05 * diameter), (np.inf, height[-1], height[-1])
        found, _ = curve_fit(profile, slices, number[height > diameter], start, bounds=bounds)
        return float(found[1])

    return measure


def g16(evidence: Evidence) -> list[Check]:
    """The slice at the belt has less than 30 % of the largest density, where the bed flows.

    In the time mean and, where it was kept, at the beginning of the cycle.
    """
    line = replicated(evidence.line("belt", "frequency"))
    flowing = {frequency: place for frequency, place in line.items() if frequency >= FLOWING}
    if not set(FREQUENCIES[1:]) <= set(flowing):
        raise Untestable("no runs at 20, 60 and 80 Hz with several beds")
    checks = []
    for frequency, place in flowing.items():
        for name, when in ((DENSITY, "time mean"), (f"{DENSITY}_at_phase_0", "phase 0")):
            try:
                share = place.measure(at_belt, name)
            except Untestable:
                if name == DENSITY:
                    raise
                continue
            what = f"ρ at the belt over the largest, {frequency:g} Hz, {when}"
            checks.append(below(what, share, 0.3, (place,)))
    return checks


def at_belt(_: np.ndarray, number: np.ndarray) -> float:
    """Return the density at the belt over the largest."""
    return float(number[0] / number.max())


def g17(evidence: Evidence) -> list[Check]:
    """Over 10, 20, 60 and 80 Hz the largest density falls and the layer widens."""
    line = along(evidence, "frequency", FREQUENCIES)
    places, over = list(line.values()), ", ".join(f"{f:g}" for f in line)
    checks = []
    for what, measure, rises in (("ρ_max", peak, False), ("width of the layer", layer_width, True)):
        groups = [place.each(measure, DENSITY) for place in places]
        name = f"{what} over f (Hz) = {over}"
        checks.append(trend(name, [groups], places, rising=rises))
    for f, place in line.items():
        width = place.measure(spread, DENSITY) / place["diameter"]
        checks.append(
            reported(f"standard deviation of the heights, {f:g} Hz", width, [place], "⟨d⟩")
        )
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


def g18(evidence: Evidence, none: float) -> list[Check]:
    """Above 1.5 times the height of the bed at 10 Hz there are beads at 60 and 80 Hz, none at 10:
    a density below ``none`` (⟨d⟩⁻²).

    The density compared is that of the first slice wholly above.
    """
    bed, *fluid = along(evidence, "frequency", (10, 60, 80)).values()
    top = 1.5 * bed.measure(half_height, DENSITY).nominal_value
    checks = []
    for place in (bed, *fluid):
        density = place.measure(_first_above(top), DENSITY) * place["diameter"] ** 2
        what = f"ρ⟨d⟩² above 1.5 bed heights, {place['frequency']:g} Hz"
        checks.append((below if place is bed else above)(what, density, none, (place,)))
    return checks


def _first_above(top: float) -> Callable[[np.ndarray, np.ndarray], float]:
    """Return the measure that is the density of the first slice wholly above a height (m)."""

    def measure(height: np.ndarray, number: np.ndarray) -> float:
        higher = np.flatnonzero(height - 0.5 * (height[1] - height[0]) >= top)
        return float(number[higher[0]]) if higher.size else nan

    return measure


def g19(evidence: Evidence) -> list[Check]:
    """Densities at four angles differ by less than those of two beds at one angle do.

    Where they differ most is told by all beds but one, see `largest_difference`; the scatter of one
    bed is that over beds and angles, as a mean over all slices.
    """
    places = list(along(evidence, "vibration_angle", (30, 45, 60, 90), frequency=60).values())
    profiles = [place.profile(DENSITY)[0] for place in places]
    shared = common_beds(places)
    if len(shared[0]) < 3:
        raise Untestable("fewer than three beds that are known at 60 Hz and 30, 45, 60, 90 degrees")
    density = np.array([each[which] for each, which in zip(profiles, shared, strict=True)])
    mean = density.mean(axis=1)
    dense = mean.mean(axis=0) > 0.01 * mean.max()
    density = density[:, :, dense] / mean.max()
    difference = largest_difference(density)
    scatter = float(np.sqrt(density.var(axis=1, ddof=1).mean()))
    # Chi-square's error of a standard deviation, its slices taken as one: they move together.
    freedom = len(places) * (len(shared[0]) - 1)
    error = measured(scatter, SIGMAS * scatter / sqrt(2 * freedom))
    ratio = quotient(difference, error)
    return [
        below("largest difference of ρ over the scatter of one bed", ratio, 1, places),
        reported("largest difference of ρ over ρ_max", difference, places),
        reported("scatter of one bed over ρ_max", scatter, places),
    ]


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
