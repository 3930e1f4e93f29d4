"""Judges of Gallas' claims about where the beads are: their density over height."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cache
from itertools import combinations
from math import nan, sqrt

import numpy as np
from scipy import stats
from scipy.optimize import curve_fit
from uncertainties import UFloat

from sim.claims.checks import (
    Numbers,
    Pair,
    above,
    below,
    conjunction_p,
    remove_votes,
    reported,
    within,
)
from sim.claims.evidence import Evidence
from sim.claims.inference import reported_order, trend
from sim.claims.place import Place, quotient, replicate_mean, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.measures import layers
from sim.papers.gallas.judges.lines import (
    bed,
    common_beds,
    complete_line,
    half_height,
    pair_label,
    peak_density,
)

DENSITY = "number_density"

#: Share that stands for all beads: their heights have a standard deviation as the width.
ALL = 1.0

#: Frequencies (Hz) that are needed of a bed that flows.
FLOWING = (20, 60, 80)


def g15(
    evidence: Evidence,
    *,
    frequency: float,
    low: float,
    high: float,
    max_deviation: float,
    end: float,
    margin: float,
) -> list[Check]:
    """Slices between two heights (⟨d⟩) deviate little from their mean; the plateau ends above.

    It ends at ``end``, within ``margin`` (both ⟨d⟩). The fit is a plateau with a linear fall to
    zero; the plateau ends where the fall begins.
    """
    place = bed(evidence, frequency)
    diameter = place["diameter"]
    density, height = place.profile(DENSITY)
    inside = (height > low * diameter) & (height < high * diameter)
    plateau = density[:, inside]
    deviation = plateau / plateau.mean(axis=1, keepdims=True) - 1
    measured_end = place.measure(plateau_end(diameter), DENSITY, grid="slices") / diameter
    top = place.measure(half_height, DENSITY) / diameter
    beads = place.measure(lambda height, number: number.sum() * (height[1] - height[0]), DENSITY)
    expected = place["beads"] / (place["width"] * diameter)
    slices = [
        within(
            f"deviation of ρ from its plateau at {z / diameter:g}⟨d⟩",
            replicate_mean(column),
            -max_deviation,
            max_deviation,
            (place,),
        )
        for z, column in zip(height[inside], deviation.T, strict=True)
    ]
    thick = float(np.diff(place.profile(DENSITY, "slices")[1][:2])[0]) / diameter
    quantity, bounds = f"end of the plateau, slices of {thick:g}⟨d⟩", (end - margin, end + margin)
    return [
        *slices,
        within(quantity, measured_end, *bounds, (place,), "⟨d⟩"),
        reported("height at which ρ is half of its plateau", top, (place,), "⟨d⟩"),
        reported("∫ρ dz over N/L", beads / expected, (place,)),
    ]


@cache
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


def g16(evidence: Evidence, *, max_ratio: float, lowest: float) -> list[Check]:
    """The slice at the belt has less than ``max_ratio`` times the largest density.

    The frequencies are those from ``lowest`` (Hz) on. The time mean decides; the density at the
    beginning of the cycle is shown, where it was recorded.
    """
    line = select_replicated(evidence.line("belt", "frequency"))
    flowing = {frequency: place for frequency, place in line.items() if frequency >= lowest}
    if not set(FLOWING) <= set(flowing):
        raise Untestable("no runs at 20, 60 and 80 Hz with several beds")
    checks, at_phase_0 = [], []
    for frequency, place in flowing.items():
        quantity = f"ρ at the belt over the largest, {frequency:g} Hz"
        share = place.measure(belt_density_ratio, DENSITY)
        checks.append(below(f"{quantity}, time mean", share, max_ratio, (place,)))
        with suppress(Untestable):
            share = place.measure(belt_density_ratio, f"{DENSITY}_at_phase_0")
            at_phase_0.append(below(f"{quantity}, phase 0", share, max_ratio, (place,)))
    return [*checks, *remove_votes(at_phase_0)]


def belt_density_ratio(_: np.ndarray, number: np.ndarray) -> float:
    """Return the density at the belt over the largest density."""
    return float(number[0] / number.max())


def g17(evidence: Evidence, *, frequencies: Numbers, shares: Numbers, margin: float) -> list[Check]:
    """Over the frequencies (Hz) the largest density falls (a), and the layer widens (b).

    Its widths hold the middle ``shares`` of the beads; both have to widen. A reversal between any
    two frequencies that is surely larger than the share ``margin`` refutes either part. That there
    is none so large must be sure as well.
    """
    line = complete_line(evidence, "frequency", frequencies)
    places, values = list(line.values()), ", ".join(f"{f:g}" for f in line)
    checks = []
    for part, quantity, measure, power, is_rising in (
        ("a", "ρ_max", peak_density, -2, False),
        *(("b", width_label(share), width_of_beads(share), 1, True) for share in shares),
    ):
        groups = [
            place.measure_replicates(measure, DENSITY) / place["diameter"] ** power
            for place in places
        ]
        check = trend(
            f"{quantity} over f (Hz) = {values}",
            [groups],
            places,
            rising=is_rising,
            margin=margin,
            labels=[f"{f:g} Hz" for f in line],
            unit="⟨d⟩⁻²" if power < 0 else "⟨d⟩",
        )
        order = "rises" if is_rising else "falls"
        likely = reported_order(f"{quantity} {order} over f", [groups], rising=is_rising)
        checks += [replace(check, part=part), likely]
    for share in (*shares, ALL):
        for f, place in line.items():
            width = place.measure(width_of_beads(share), DENSITY) / place["diameter"]
            checks.append(reported(f"{width_label(share)}, {f:g} Hz", width, [place], "⟨d⟩"))
    return checks


def g18(
    evidence: Evidence, *, empty_density: float, heights: float, still: float, fluid: Numbers
) -> list[Check]:
    """Above some heights of the still bed there are beads at fluid frequencies (Hz), else none.

    None means a density below ``empty_density`` (⟨d⟩⁻²), in the first slice that is wholly above.
    """
    block, *beds = complete_line(evidence, "frequency", (still, *fluid)).values()
    top = heights * block.measure(half_height, DENSITY).nominal_value

    def density_above(height: np.ndarray, number: np.ndarray) -> float:
        higher = np.flatnonzero(height - 0.5 * (height[1] - height[0]) >= top)
        return float(number[higher[0]]) if higher.size else nan

    checks = []
    for place in (block, *beds):
        density = place.measure(density_above, DENSITY) * place["diameter"] ** 2
        quantity = f"ρ⟨d⟩² above {heights} bed heights, {place['frequency']:g} Hz"
        check = below if place is block else above
        checks.append(check(quantity, density, empty_density, (place,)))
    return checks


def g19(evidence: Evidence, *, frequency: float, angles: Numbers) -> list[Check]:
    """Densities at several angles differ by less than those of two beds at one angle do.

    The scatter of one bed is a mean over all slices, over beds and angles. See
    `compare_differences`.
    """
    line = complete_line(evidence, "vibration_angle", angles, frequency=frequency)
    places = list(line.values())
    profiles = [place.profile(DENSITY)[0] for place in places]
    shared = common_beds(places)
    if len(shared[0]) < 3:
        where = f"{frequency} Hz and {', '.join(map(str, angles))} degrees"
        raise Untestable(f"fewer than three beds that are known at {where}")
    density = np.array([profile[beds] for profile, beds in zip(profiles, shared, strict=True)])
    mean = density.mean(axis=1)
    dense = mean.mean(axis=0) > 0.01 * mean.max()
    density = density[:, :, dense] / mean.max()
    scatter = float(np.sqrt(density.var(axis=1, ddof=1).mean()))
    difference, p_values = compare_differences(density, scatter)
    check = below(
        "largest difference of ρ over the scatter of one bed", difference / scatter, 1, places
    )
    return [
        replace(check, tested=p_values),
        reported("largest difference of ρ over ρ_max", difference, places),
        reported("scatter of one bed over ρ_max", scatter, places),
    ]


def compare_differences(density: np.ndarray, most: float) -> tuple[UFloat, Pair]:
    """Return the largest difference of densities (A, R, S), and p-values against a threshold.

    Differences are between means over beds, of two angles in a slice. The p-values say that all of
    them are below ``most``, for which each must be (an intersection of unions), and that any is
    above it, with Bonferroni's correction. The largest of many differences is more than the true
    one; the first p-value does not suffer, as it is never too small. Beds are compared with
    themselves: their beads are the same at all angles. ``most`` is a scatter of these beds, whose
    error is that of chi-square, its slices taken as one: they move together.
    """
    number, beds, _ = density.shape
    differences = np.array(
        [density[one] - density[two] for one, two in combinations(range(number), 2)]
    )
    size = np.abs(differences.mean(axis=1))
    error = differences.std(axis=1, ddof=1) / sqrt(beds)
    pair, slice_index = np.unravel_index(size.argmax(), size.shape)
    largest = differences[pair, :, slice_index]
    with_scatter = np.hypot(error, most / sqrt(2 * number * (beds - 1)))
    p_below, p_above = stats.t.sf(
        np.array([1, -1])[:, None, None] * (most - size) / with_scatter, beds - 1
    )
    p_values = float(p_below.max()), conjunction_p(p_above.ravel().tolist(), 1)
    return replicate_mean(np.sign(largest.mean()) * largest), p_values


def g20(
    evidence: Evidence,
    *,
    frequency: float,
    loose: Pair,
    shearing: Pair,
    usual: Pair,
    firm: Pair,
    share: float,
    margin: float,
    height: float,
    max_change: float,
) -> list[Check]:
    """Less friction widens the layer (a); beads below ``height`` (⟨d⟩) hardly change (b).

    Pairs are damping and shear damping (g). The width is that of the middle ``share`` of the beads.
    """
    at_loose, at_shearing, at_usual, at_firm = (
        bed(evidence, frequency, damping=damping, shear_damping=shear)
        for damping, shear in (loose, shearing, usual, firm)
    )
    checks = []
    for wide, narrow in ((at_loose, at_usual), (at_loose, at_firm), (at_shearing, at_firm)):
        places = narrow, wide
        widths = [place.measure_replicates(width_of_beads(share), DENSITY) for place in places]
        labels = [_pair_label(place) for place in places]
        quantity = f"{width_label(share)}, {labels[1]} over {labels[0]}"
        check = trend(quantity, [widths], places, margin=margin, labels=labels)
        ratio = quotient(*map(replicate_mean, widths[::-1]))
        checks += [replace(check, part="a"), reported(quantity, ratio, places)]
    for place in (at_loose, at_shearing):
        change = density_near_belt(place, height) / density_near_belt(at_firm, height) - 1
        pair = f"{_pair_label(place)} over {_pair_label(at_firm)}"
        quantity = f"beads below {height}⟨d⟩ at {pair}, less 1"
        check = within(quantity, change, -max_change, max_change, (place, at_firm))
        checks.append(replace(check, part="b"))
    return checks


def density_near_belt(place: Place, height: float) -> UFloat:
    """Return the number of beads per area (m⁻²) in the slices below ``height`` (⟨d⟩)."""
    top = height * place["diameter"]
    return place.measure(lambda z, number: number[z < top].mean(), DENSITY)


def _pair_label(place: Place) -> str:
    return pair_label(place["damping"], place["shear_damping"])


@cache
def width_of_beads(share: float) -> Callable[[np.ndarray, np.ndarray], float]:
    """Return a function of height and number density: the width (m) of the layer.

    It is the range that holds the middle ``share`` of the beads, or the standard deviation of the
    heights of `ALL`. A threshold of density would jump where the lowest slice crosses it.
    """

    def width(height: np.ndarray, number: np.ndarray) -> float:
        if share == ALL:
            mean = np.average(height, weights=number)
            return float(np.sqrt(np.average((height - mean) ** 2, weights=number)))
        low, high = (layers.level(height, number, 0.5 + side * share / 2) for side in (-1, 1))
        return high - low

    return width


def width_label(share: float) -> str:
    """Return the name of the width of `width_of_beads`."""
    return "standard deviation of heights" if share == ALL else f"middle {100 * share:g} % of beads"
