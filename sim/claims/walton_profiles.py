"""Judges of Walton's claims about profiles: where flows shear, how dense they are, their plugs."""

from collections.abc import Callable
from math import inf

import numpy as np

from sim.claims.checks import above, below, reported, withheld
from sim.claims.chute import (
    DEEPEST,
    WIDTHS,
    age,
    at_depth,
    base,
    lasting,
    of_settled,
    repeated,
    stiffer,
    still_changing,
    unlike,
)
from sim.claims.evidence import Evidence
from sim.claims.inference import share_above, trend
from sim.claims.place import Place, joined
from sim.claims.states import PROFILES, of_most, plug_shares, share_with
from sim.claims.trends import least, mean_of_others
from sim.claims.verdict import Check, Untestable
from sim.dataset.measures import layers

#: Bins with less than this share of the mass do not count.
THIN = 0.01

#: Replicates without which a statement about all bins at once cannot be decided.
MANY = 6

#: Depths of each claim: all below 5 and 2.5, intermediate, with a plug, the deepest, and those over
#: which the shear layer thins.
SHALLOW, SHALLOWEST, MIDDLE, DEEP = 5, 2.5, (3.5, 5, 10), (10, 20, DEEPEST)
THINNING = (5, 10, 20, DEEPEST)

#: What is more often so than not is often so.
OFTEN = 0.5

#: Least packing of the plug, its largest standard deviation relative to it, least difference from
#: the shear layer, and the age in √(σ/g) from which a flow of that depth counts.
DENSE, UNIFORM, LOOSER, OLD = 0.60, 0.05, 0.05, 2000

#: What rounding to whole samples leaves of an age.
ROUNDED = 0.99


def w10(evidence: Evidence) -> list[Check]:
    """Steps of the velocity from each slice with 1 % of the mass to the next; all bins at once."""
    flows = _thin(evidence, SHALLOW)
    checks = (
        above(
            f"least du/dz, n = {n:g}", least(_steps(place, "velocity_profile")), 0, [place], "1/s"
        )
        for n, place in flows.items()
    )
    return of_settled(checks, flows.values())


def w11(evidence: Evidence, least_share: float) -> list[Check]:
    """Share of all runs of deep flows, whatever their start and cell, that ride as a plug.

    A plug is more than ``least_share`` of the depth. Runs that accelerate do not count.
    """
    cells, places = {}, []
    for cell in WIDTHS:
        lines = (evidence.line("chute", "initial_velocity", depth=n, cell=cell) for n in DEEP)
        flows = [place for line in lines for place in line.values()]
        found = [_steady_plugs(place) for place in flows]
        if found:
            cells[cell] = np.concatenate(found) > least_share
            places += flows
    if len(cells) < 2:
        raise Untestable("no flows at n = 10, 20 and 40 in cells of two widths")
    plugs = np.concatenate(list(cells.values()))
    if not plugs.size:
        raise Untestable("all flows at n = 10, 20 and 40 accelerate")
    checks = [share_above("share of runs with a plug", int(plugs.sum()), plugs.size, OFTEN, places)]
    for cell, own in cells.items():
        if own.size:
            what = f"share of runs with a plug in cells of {cell} σ, {own.size} runs"
            checks.append(reported(what, share_with(own)))
    return checks


def _steady_plugs(place: Place) -> np.ndarray:
    """Return the share of the depth that is plug in the replicates that do not accelerate."""
    return plug_shares(place)[place.values("regime") != "accelerating"]


def w12(evidence: Evidence) -> list[Check]:
    """Steps of the packing from each layer of a diameter to the next; all of them at once.

    Slices thinner than a sphere show the gap between layers as well; their largest steps are
    reported, from the plane and from the first centres upwards.
    """
    flows = _thin(evidence, SHALLOWEST)
    checks = []
    for n, place in flows.items():
        layered = np.diff(_by_layers(place), axis=1)
        if not layered.size:
            raise Untestable(f"fewer than two layers at n = {n:g}")
        what = "largest rise of the packing with height"
        checks.append(below(f"{what}, by layers, n = {n:g}", -least(-layered), 0, [place]))
        for start, lowest in (("the plane", 0.0), ("the first centres", 0.5 * place["diameter"])):
            sliced = _steps(place, "packing_profile", lowest, 1.0)
            told = f"{what}, by slices from {start} on, n = {n:g}"
            checks.append(reported(told, -least(-sliced), [place]))
    return of_settled(checks, flows.values())


def w13(evidence: Evidence) -> list[Check]:
    """Packing by layers of a diameter: the densest inner one against the lowest and the highest."""
    flows = {n: place for n, place in repeated(base(evidence)).items() if n in MIDDLE}
    if len(flows) < len(MIDDLE):
        raise Untestable("no flows at n = 3.5, 5 and 10 that have replicates")
    checks = []
    for n, place in flows.items():
        rows = _by_layers(place)
        if len(rows) < 2 or rows.shape[1] < 3:
            raise Untestable(f"fewer than three layers, or than two replicates, at n = {n:g}")
        for name, end in (("lowest", 0), ("highest", -1)):
            what = f"packing of the densest inner layer less that of the {name}, n = {n:g}"
            checks.append(above(what, joined(_densest_inner(rows) - rows[:, end]), 0, [place]))
    return of_settled(checks, flows.values())


def _densest_inner(rows: np.ndarray) -> np.ndarray:
    """Return the packing (R) of the densest inner layer of layers (R, L).

    Which one it is, is told by all other replicates, see `mean_of_others`.
    """
    chosen = 1 + mean_of_others(rows)[:, 1:-1].argmax(axis=1)
    return rows[np.arange(len(rows)), chosen]


def w14(evidence: Evidence) -> list[Check]:
    """The deepest flow above and below its shear depth: packing, its spread, the difference."""
    place = _oldest(lasting(evidence), DEEPEST)

    def variation(plug: np.ndarray, _: float) -> float:
        return plug.std(ddof=1) / plug.mean() if plug.size > 1 else np.nan

    checks = []
    for what, function, against, threshold in (
        ("packing of the plug", lambda plug, _: plug.mean(), above, DENSE),
        ("standard deviation of its packing over its mean", variation, below, UNIFORM),
        (
            "packing of the plug less that of the shear layer",
            lambda plug, sheared: plug.mean() - sheared,
            above,
            LOOSER,
        ),
    ):
        values = place.each(_of_plug(place, function), *PROFILES)
        check = against(f"{what}, {at_depth(place)}", joined(values), threshold, [place])
        checks.append(of_most(check, place, values))
    young = f"averaged from {age(place):.0f} √(σ/g) on: runs of {OLD:,} and more"
    return withheld(of_settled(checks, [place]), young if age(place) < ROUNDED * OLD else "")


def _oldest(evidence: Evidence, depth: float) -> Place:
    """Return the flow of a depth that was averaged from the latest time on, one with replicates
    before others."""
    flows = evidence.line("chute", "transient", depth=depth)
    if not flows:
        raise Untestable(f"no {evidence.protocol} run of the chute at depth {depth:g}")
    line = repeated(flows) or flows
    return line[max(line)]


def w17(evidence: Evidence) -> list[Check]:
    """Trend of the shear depth over the depths, and of the share of the depth that it takes.

    The flows are those of one cell and one age.
    """
    line = _thinning(lasting(evidence))
    if len(line) < 3:
        raise Untestable("no cell with three depths of 5, 10, 20 and 40 that have replicates")
    places = list(line.values())
    over = ", ".join(f"{n:g}" for n in line) + stiffer(places[-1])
    depths = [place.values("shear_depth") for place in places]
    tops = [
        place.each(lambda z, packing: layers.surface(z, packing), PROFILES[1]) for place in places
    ]
    fractions = [depth / top for depth, top in zip(depths, tops, strict=True)]
    checks = [
        trend(f"shear depth over n = {over}", [depths], places, rising=False),
        trend(f"its share of the depth over n = {over}", [fractions], places, rising=False),
    ]
    reasons = [unlike(places), *map(still_changing, places)]
    missing = "" if set(line) == set(THINNING) else f"n = {over} alone in one cell"
    return withheld(checks, "; ".join(filter(None, [missing, *reasons])))


def _thinning(evidence: Evidence) -> dict[float, Place]:
    """Return the flows over which the shear layer is to thin: the most depths of one cell and age.

    Of as many those of the narrowest cell, then the oldest.
    """
    found: list[dict[float, Place]] = [{}]
    for cell in WIDTHS:
        starts = {
            start
            for n in THINNING
            for start in evidence.line("chute", "transient", depth=n, cell=cell)
        }
        for start in sorted(starts, reverse=True):
            line = repeated(evidence.line("chute", "depth", cell=cell, transient=start))
            found.append({n: place for n, place in line.items() if n in THINNING})
    return max(found, key=len)


def w18(evidence: Evidence) -> list[Check]:
    """The slowest flow: the least shear above any height, relative to that below it.

    A plug has less than 5 % there (W11). The least over the largest du/dz is reported.
    """
    flows = repeated(base(evidence, 1))
    if len(flows) < 3:
        raise Untestable("fewer than three flows with n ≥ 1 that have replicates")
    n, place = min(flows.items(), key=lambda flow: flow[1].velocity.nominal_value)

    def stiffest(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        shear = layers.relative_shear(height, velocity, packing, place["diameter"])[1]
        return min(shear, default=inf)

    shear, even = (place.measure(each, *PROFILES) for each in (stiffest, _evenness(place)))
    what = f"least shear above a height over that below it, n = {n:g}"
    checks = [
        above(what, shear, layers.UNSHEARED, [place]),
        reported(f"least over largest du/dz, n = {n:g}", even, [place]),
    ]
    return of_settled(checks, [place])


def _thin(evidence: Evidence, below_depth: float) -> dict[float, Place]:
    """Return the flows of less than a depth, from one layer on, with many replicates."""
    flows = {n: place for n, place in base(evidence, 1).items() if n < below_depth}
    found = repeated(flows, MANY)
    if not found:
        raise Untestable(f"no flow with 1 ≤ n < {below_depth:g} that has {MANY} replicates")
    return found


def _steps(place: Place, name: str, lowest: float = 0.0, scale: float | None = None) -> np.ndarray:
    """Return the steps (R, B) of a profile between slices with 1 % of the mass, over ``scale``.

    Without a scale they are slopes. Slices below ``lowest`` (m) do not count.
    """
    (rows, height), (packing, _) = place.profile(name), place.profile("packing_profile")
    mean = packing.mean(axis=0)
    counted = (mean > THIN * mean.sum()) & (height >= lowest)
    return np.diff(rows[:, counted], axis=1) / (scale or np.diff(height[counted]))


def _by_layers(place: Place) -> np.ndarray:
    """Return the packing by layers of a diameter (R, L), of those that all replicates have."""
    packing, height = place.profile("packing_profile")
    rows = [layers.packing_by_diameters(height, row, place["diameter"]) for row in packing]
    return np.array([row[: min(map(len, rows))] for row in rows])


def _evenness(place: Place) -> Callable[..., float]:
    """Return the function of profiles that gives the least over the largest mean du/dz.

    The means are over a diameter, because a slice shares its spheres with its neighbors.
    """

    def evenness(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        across = round(place["diameter"] / (height[1] - height[0]))
        counted = velocity[packing > THIN * packing.sum()]
        slopes = counted[across:] - counted[:-across]
        rises = slopes.size > 1 and slopes.max() > 0
        return slopes.min() / slopes.max() if rises else np.nan

    return evenness


def _of_plug(place: Place, function: Callable[[np.ndarray, float], float]) -> Callable[..., float]:
    """Return a function of profiles: of the packing by layers of the plug, and of what it rides on.

    Layers of two diameters, because those of a crystal are no diameter apart. The gap under the
    centres of the lowest spheres belongs to no layer.
    """
    diameter = place["diameter"]

    def measure(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        depth = layers.shear_depth(height, velocity, packing, diameter)
        rows = layers.packing_by_diameters(height, packing, diameter, layers=2)
        plug = rows[2 * diameter * np.arange(len(rows)) >= depth]
        sheared = packing[(height >= 0.5 * diameter) & (height < depth)]
        return function(plug, sheared.mean()) if plug.size and sheared.size else np.nan

    return measure
