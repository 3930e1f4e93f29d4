"""Judges of Gallas' claims about where the beads are: their density over height."""

from collections.abc import Callable, Sequence
from math import inf, nan, sqrt

import numpy as np
from scipy.optimize import curve_fit
from uncertainties import UFloat

from sim.claims.bed import half_height, height_spread, layer_width, peak_density
from sim.claims.checks import above, below, reported, within
from sim.claims.evidence import Evidence
from sim.claims.inference import trend
from sim.claims.lines import MIN_FLOW_FREQUENCY, common_beds, complete_line, select_replicated
from sim.claims.place import Place, quotient, replicate_mean, with_interval
from sim.claims.trends import mean_of_others
from sim.claims.verdict import SIGMAS, Check, Untestable

DENSITY = "number_density"

#: Frequencies (Hz) of Fig. 2a.
FREQUENCIES = (10, 20, 60, 80)


def g15(evidence: Evidence) -> list[Check]:
    """At 10 Hz each slice from 2 to 8 ⟨d⟩ is within 10 % of their mean; the plateau ends at 9 ⟨d⟩.

    The fit is a plateau with a linear fall to zero; the plateau ends where the fall begins.
    """
    place = evidence.at("belt", frequency=10)
    diameter = place["diameter"]
    density, height = place.profile(DENSITY)
    inside = (height > 2 * diameter) & (height < 8 * diameter)
    plateau = density[:, inside]
    deviation = plateau / plateau.mean(axis=1, keepdims=True) - 1
    end = place.measure(plateau_end(diameter), DENSITY, grid="slices") / diameter
    top = place.measure(half_height, DENSITY) / diameter
    beads = place.measure(lambda height, number: number.sum() * (height[1] - height[0]), DENSITY)
    expected = place["beads"] / (place["width"] * diameter)
    slices = [
        within(
            f"deviation of ρ from its plateau at {z / diameter:g}⟨d⟩",
            replicate_mean(column),
            -0.1,
            0.1,
            (place,),
        )
        for z, column in zip(height[inside], deviation.T, strict=True)
    ]
    thick = float(np.diff(place.profile(DENSITY, "slices")[1][:2])[0]) / diameter
    return [
        *slices,
        within(f"end of the plateau, slices of {thick:g}⟨d⟩", end, 8, 10, (place,), "⟨d⟩"),
        reported("height at which ρ is half of its plateau", top, (place,), "⟨d⟩"),
        reported("∫ρ dz over N/L", beads / expected, (place,)),
    ]


def plateau_end(diameter: float) -> Callable[[np.ndarray, np.ndarray], float]:
    """Return a function of height and density: the height (m) at which the plateau ends.

    It fits, by least squares, a constant up to there and a straight fall to zero above, averaged
    over each slice. The lowest ``diameter`` (m), where beads lie on the belt, does not count.
    """

    def measure(height: np.ndarray, number: np.ndarray) -> float:
        slices, width = height[height > diameter], height[1] - height[0]
        fine = slices[:, None] + width * (np.arange(20) / 20 - 0.475)

        def profile(_: np.ndarray, level: float, end: float, fall: float) -> np.ndarray:
            return level * np.clip(1 - (fine - end) / fall, 0, 1).mean(axis=1)

        level = float(np.median(number[number > 0.5 * number.max()]))
        start = level, half_height(height, number) - 0.5 * diameter, diameter
        bounds = (0, 0, 0.05 * diameter), (np.inf, height[-1], height[-1])
        fit, _ = curve_fit(profile, slices, number[height > diameter], start, bounds=bounds)
        return float(fit[1])

    return measure


def g16(evidence: Evidence) -> list[Check]:
    """The slice at the belt has less than 30 % of the largest density, where the bed flows.

    This is tested in the time mean and, where it was recorded, at the beginning of the cycle.
    """
    line = select_replicated(evidence.line("belt", "frequency"))
    flowing = {
        frequency: place for frequency, place in line.items() if frequency >= MIN_FLOW_FREQUENCY
    }
    if not set(FREQUENCIES[1:]) <= set(flowing):
        raise Untestable("no runs at 20, 60 and 80 Hz with several beds")
    checks = []
    for frequency, place in flowing.items():
        for name, phase_label in ((DENSITY, "time mean"), (f"{DENSITY}_at_phase_0", "phase 0")):
            try:
                share = place.measure(belt_density_ratio, name)
            except Untestable:
                if name == DENSITY:
                    raise
                continue
            quantity = f"ρ at the belt over the largest, {frequency:g} Hz, {phase_label}"
            checks.append(below(quantity, share, 0.3, (place,)))
    return checks


def belt_density_ratio(_: np.ndarray, number: np.ndarray) -> float:
    """Return the density at the belt over the largest density."""
    return float(number[0] / number.max())


def g17(evidence: Evidence) -> list[Check]:
    """Over 10, 20, 60 and 80 Hz the largest density falls and the layer widens."""
    line = complete_line(evidence, "frequency", FREQUENCIES)
    places, values = list(line.values()), ", ".join(f"{f:g}" for f in line)
    checks = []
    for quantity, measure, is_rising in (
        ("ρ_max", peak_density, False),
        ("width of the layer", layer_width, True),
    ):
        groups = [place.measure_replicates(measure, DENSITY) for place in places]
        name = f"{quantity} over f (Hz) = {values}"
        checks.append(trend(name, [groups], places, rising=is_rising))
    for f, place in line.items():
        width = place.measure(height_spread, DENSITY) / place["diameter"]
        checks.append(
            reported(f"standard deviation of the heights, {f:g} Hz", width, [place], "⟨d⟩")
        )
    return checks


def check_wider(wide: Place, narrow: Place, comparison: str) -> list[Check]:
    """Return the check that the layer is wider at one place than at another.

    The standard deviation of all heights is reported only: few beads high above can dominate it.
    """
    checks = []
    for quantity, measure, threshold in (
        ("width of the layer", layer_width, 0),
        ("standard deviation of the heights", height_spread, -inf),
    ):
        gain = (wide.measure(measure, DENSITY) - narrow.measure(measure, DENSITY)) / wide[
            "diameter"
        ]
        checks.append(above(f"{quantity} {comparison}", gain, threshold, (wide, narrow), "⟨d⟩"))
    return checks


def g18(evidence: Evidence, empty_density: float) -> list[Check]:
    """Above 1.5 heights of the bed at 10 Hz there are beads at 60 and 80 Hz, and none at 10 Hz.

    None means a density below ``empty_density`` (⟨d⟩⁻²), in the first slice that is wholly above.
    """
    bed, *fluid = complete_line(evidence, "frequency", (10, 60, 80)).values()
    top = 1.5 * bed.measure(half_height, DENSITY).nominal_value
    checks = []
    for place in (bed, *fluid):
        density = place.measure(_density_above(top), DENSITY) * place["diameter"] ** 2
        quantity = f"ρ⟨d⟩² above 1.5 bed heights, {place['frequency']:g} Hz"
        checks.append(
            (below if place is bed else above)(quantity, density, empty_density, (place,))
        )
    return checks


def _density_above(top: float) -> Callable[[np.ndarray, np.ndarray], float]:
    """Return a function of height and density: the density of the first slice above ``top`` (m)."""

    def measure(height: np.ndarray, number: np.ndarray) -> float:
        higher = np.flatnonzero(height - 0.5 * (height[1] - height[0]) >= top)
        return float(number[higher[0]]) if higher.size else nan

    return measure


def g19(evidence: Evidence) -> list[Check]:
    """Densities at four angles differ by less than those of two beds at one angle do.

    All beds but one select the largest difference, see `largest_difference`. The scatter of one bed
    is a mean over all slices, over beds and angles.
    """
    places = list(
        complete_line(evidence, "vibration_angle", (30, 45, 60, 90), frequency=60).values()
    )
    profiles = [place.profile(DENSITY)[0] for place in places]
    shared = common_beds(places)
    if len(shared[0]) < 3:
        raise Untestable("fewer than three beds that are known at 60 Hz and 30, 45, 60, 90 degrees")
    density = np.array([profile[beds] for profile, beds in zip(profiles, shared, strict=True)])
    mean = density.mean(axis=1)
    dense = mean.mean(axis=0) > 0.01 * mean.max()
    density = density[:, :, dense] / mean.max()
    difference = largest_difference(density)
    scatter = float(np.sqrt(density.var(axis=1, ddof=1).mean()))
    # Chi-square's error of a standard deviation, its slices taken as one: they move together.
    freedom = len(places) * (len(shared[0]) - 1)
    error = with_interval(scatter, SIGMAS * scatter / sqrt(2 * freedom))
    ratio = quotient(difference, error)
    return [
        below("largest difference of ρ over the scatter of one bed", ratio, 1, places),
        reported("largest difference of ρ over ρ_max", difference, places),
        reported("scatter of one bed over ρ_max", scatter, places),
    ]


def largest_difference(density: np.ndarray) -> UFloat:
    """Return the largest difference of mean densities (A, R, S) between two angles in a slice.

    For each bed in turn, all other beds select the angles and the slice, and the bed itself gives
    the difference. So the choice of the largest of many differences adds no bias. The sizes of a
    bed's beads are the same at all angles, so they do not count as scatter.
    """
    differences = []
    for bed, mean in enumerate(mean_of_others(density, axis=1).swapaxes(0, 1)):
        slice_index = int(np.ptp(mean, axis=0).argmax())
        high, low = int(mean[:, slice_index].argmax()), int(mean[:, slice_index].argmin())
        differences.append(density[high, bed, slice_index] - density[low, bed, slice_index])
    return replicate_mean(np.array(differences))


def g20(evidence: Evidence) -> list[Check]:
    """At 80 Hz less friction widens the layer; the number of beads below 2⟨d⟩ stays within 10 %."""
    pairs = ((10, 10), (0, 50), (50, 50), (50, 100))
    places_by_pair = {
        pair: evidence.at("belt", frequency=80, damping=pair[0], shear_damping=pair[1])
        for pair in pairs
    }
    checks = []
    for less, more in (((10, 10), (50, 50)), ((10, 10), (50, 100)), ((0, 50), (50, 100))):
        checks += check_wider(
            places_by_pair[less],
            places_by_pair[more],
            f"at {_pair_label(less)} less {_pair_label(more)}",
        )
    firm = places_by_pair[50, 100]
    for pair in pairs[:2]:
        change = density_near_belt(places_by_pair[pair]) / density_near_belt(firm) - 1
        quantity = f"beads below 2⟨d⟩ at {_pair_label(pair)} over {_pair_label((50, 100))}, less 1"
        checks.append(within(quantity, change, -0.1, 0.1, (places_by_pair[pair], firm)))
    return checks


def density_near_belt(place: Place) -> UFloat:
    """Return the number of beads per area (m⁻²) in the slices below 2⟨d⟩."""
    top = 2 * place["diameter"]
    return place.measure(lambda height, number: number[height < top].mean(), DENSITY)


def _pair_label(pair: Sequence[float]) -> str:
    return "({:g}g, {:g}g)".format(*pair)
