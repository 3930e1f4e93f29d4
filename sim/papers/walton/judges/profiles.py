"""Judges of Walton's claims about profiles: shear, density and plugs over height."""

from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np

from sim.claims.checks import Numbers, above, below, remove_votes, reported, withhold
from sim.claims.claim import fill
from sim.claims.evidence import Evidence
from sim.claims.inference import (
    LIKELIHOOD,
    mean_of_others,
    reported_share,
    share_above,
    smallest_mean,
    trend,
)
from sim.claims.place import Place, replicate_mean, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.measures import layers
from sim.papers.walton.judges.chute import (
    CELLS,
    PROFILES,
    age,
    base_flows,
    depth_label,
    flows_of_one_age,
    majority_if_mixed,
    plug_shares,
    reasons_unrankable,
    stiffness_suffix,
    withhold_unsettled,
)

#: Least share of the mass of a bin that counts, where a claim gives none.
MIN_MASS_SHARE = 0.01

#: Least number of replicates for a statement about all bins at once.
MIN_REPLICATES = 6

#: Depths below which flows are shallow, and those of the shallowest.
SHALLOW, SHALLOWEST = 5, 2.5

#: Grid of the readings on which packings of slices are compared instead of those of layers.
SLICES = "slices"

#: Factor on an age that allows for rounding to whole samples.
AGE_ROUNDING = 0.99


def w10(evidence: Evidence, *, min_mass_share: float) -> list[Check]:
    """Steps of the velocity from each slice with enough mass to the next; all bins at once."""
    flows = _shallow_flows(evidence, SHALLOW)
    checks = (
        above(
            f"least du/dz, n = {n:g}",
            smallest_mean(_steps(place, "velocity_profile", min_mass_share=min_mass_share)),
            0,
            [place],
            "1/s",
        )
        for n, place in flows.items()
    )
    return withhold_unsettled(checks, flows.values())


def w11(
    evidence: Evidence, *, min_share: float, depths: Numbers, cell: float, majority: float
) -> list[Check]:
    """Share of the runs of deep flows in cells of one width that ride as a plug.

    The cells are ``cell`` (σ) wide unless the reading has another width.
    """
    where = {"cell": evidence.reading.get("cell", cell)}
    lines = [evidence.line("chute", "initial_velocity", depth=n, **where) for n in depths]
    places = [place for line in lines for place in line.values()]
    # The share of the depth that the plug takes, of replicates that do not accelerate.
    shares = [plug_shares(place)[place.values("regime") != "accelerating"] for place in places]
    if not any(map(len, shares)):
        label = fill("n = {depths:and} in cells of {cell:g} σ", {"depths": depths, **where})
        raise Untestable(f"no flows at {label} that do not accelerate")
    depths_run = [*dict.fromkeys(place["depth"] for place in places)]
    label = f"n = {', '.join(f'{n:g}' for n in depths_run)} in cells of {where['cell']:g} σ"
    plugs = np.concatenate(shares) > min_share
    quantity = "share of runs with a plug"
    checks = [share_above(f"{quantity}, {label}", int(plugs.sum()), plugs.size, majority, places)]
    for n in depths_run if len(depths_run) > 1 else ():
        of_depth = [
            share for place, share in zip(places, shares, strict=True) if place["depth"] == n
        ]
        ride = np.concatenate(of_depth) > min_share
        if ride.size:
            label = f"{quantity}, n = {n:g} alone in cells of {where['cell']:g} σ"
            checks.append(reported_share(label, int(ride.sum()), ride.size))
    return checks


def w12(evidence: Evidence) -> list[Check]:
    """Steps of the packing from each layer of a diameter to the next, all tested at once.

    On the grid of slices, which are thinner than a sphere, steps from the first centres upwards are
    tested instead. Steps on the other grid, and by slices from the plane upwards, are reported.
    """
    flows = _shallow_flows(evidence, SHALLOWEST)
    checks = []
    for n, place in flows.items():
        layered = np.diff(_layer_packing(place), axis=1)
        if not layered.size:
            raise Untestable(f"fewer than two layers at n = {n:g}")
        quantity = "largest rise of the packing with height"
        centres, plane = (
            _steps(place, "packing_profile", lowest, 1.0)
            for lowest in (0.5 * place["diameter"], 0.0)
        )
        by_grid = [
            below(f"{quantity}, by {name}, n = {n:g}", -smallest_mean(-steps), 0, [place])
            for name, steps in (("layers", layered), ("slices from the first centres on", centres))
        ]
        if evidence.grid == SLICES:
            by_grid.reverse()
        label = f"{quantity}, by slices from the plane on, n = {n:g}"
        checks += [
            by_grid[0],
            *remove_votes(by_grid[1:]),
            reported(label, -smallest_mean(-plane), [place]),
            *(
                reported_share(
                    f"{LIKELIHOOD} the packing never rises, by {name}, n = {n:g}",
                    int((steps <= 0).all(axis=1).sum()),
                    len(steps),
                )
                for name, steps in (("layers", layered), ("slices", centres))
            ),
        ]
    return withhold_unsettled(checks, flows.values())


def w13(evidence: Evidence, *, depths: Numbers) -> list[Check]:
    """Packing by layers of a diameter: the densest inner one against the lowest and the highest."""
    flows = {
        n: place for n, place in select_replicated(base_flows(evidence)).items() if n in depths
    }
    if len(flows) < len(depths):
        missing = fill("no flows at n = {depths:and} that have replicates", {"depths": depths})
        raise Untestable(missing)
    checks = []
    for n, place in flows.items():
        rows = _layer_packing(place)
        if len(rows) < 2 or rows.shape[1] < 3:
            raise Untestable(f"fewer than three layers, or than two replicates, at n = {n:g}")
        for name, end in (("lowest", 0), ("highest", -1)):
            quantity = f"packing of the densest inner layer less that of the {name}, n = {n:g}"
            checks.append(
                above(quantity, replicate_mean(_densest_inner(rows) - rows[:, end]), 0, [place])
            )
    return withhold_unsettled(checks, flows.values())


def _densest_inner(rows: np.ndarray) -> np.ndarray:
    """Return the packing (R) of the densest inner layer of layers (R, L).

    All other replicates select the layer, see `mean_of_others`.
    """
    layer = 1 + mean_of_others(rows)[:, 1:-1].argmax(axis=1)
    return rows[np.arange(len(rows)), layer]


def w14(
    evidence: Evidence,
    *,
    min_age: float,
    min_packing: float,
    max_spread: float,
    min_difference: float,
    depth: float,
    stiffness: float,
) -> list[Check]:
    """The deepest flow above and below its shear depth: packing, its spread, the difference.

    It counts from ``min_age`` (√(σ/g)) on, with spheres of one ``stiffness`` (N/m).
    """
    place = _oldest(evidence.with_reading(stiffness=stiffness), depth)

    def variation(plug: np.ndarray, _: float) -> float:
        return plug.std(ddof=1) / plug.mean() if plug.size > 1 else np.nan

    checks = []
    for quantity, function, compare, threshold in (
        ("packing of the plug", lambda plug, _: plug.mean(), above, min_packing),
        ("standard deviation of its packing over its mean", variation, below, max_spread),
        (
            "packing of the plug less that of the shear layer",
            lambda plug, sheared: plug.mean() - sheared,
            above,
            min_difference,
        ),
    ):
        values = place.measure_replicates(_plug_measure(place, function), *PROFILES)
        check = compare(
            f"{quantity}, {depth_label(place)}", replicate_mean(values), threshold, [place]
        )
        checks.append(majority_if_mixed(check, place, values))
    reason = f"averaged from {age(place):.0f} √(σ/g) on: runs of {min_age:,} and more"
    return withhold(
        withhold_unsettled(checks, [place]), reason if age(place) < AGE_ROUNDING * min_age else ""
    )


def _oldest(evidence: Evidence, depth: float) -> Place:
    """Return the flow of a depth with the latest start of averaging.

    Flows with replicates are preferred. Raises `Untestable` if there is no flow.
    """
    flows = evidence.line("chute", "transient", depth=depth)
    if not flows:
        raise Untestable(f"no {evidence.protocol} run of the chute at depth {depth:g}")
    line = select_replicated(flows) or flows
    return line[max(line)]


def w17(evidence: Evidence, *, depths: Numbers, stiffness: float) -> list[Check]:
    """Trend of the shear depth over the depths (a), and of its share of the depth (b).

    The flows are those of one cell, one age and one ``stiffness`` (N/m).
    """
    wheres = [{"depth": n, "cell": CELLS[n]} for n in depths]
    places = flows_of_one_age(evidence.with_reading(stiffness=stiffness), wheres)
    depths_text = f"{', '.join(f'{n:g}' for n in depths)}{stiffness_suffix(places[-1])}"
    thickness = [place.values("shear_depth") for place in places]
    tops = [
        place.measure_replicates(lambda z, packing: layers.surface(z, packing), PROFILES[1])
        for place in places
    ]
    fractions = [layer / top for layer, top in zip(thickness, tops, strict=True)]
    checks = [
        replace(
            trend(f"{quantity} over n = {depths_text}", [groups], places, rising=False), part=part
        )
        for part, quantity, groups in (
            ("a", "shear depth", thickness),
            ("b", "its share of the depth", fractions),
        )
    ]
    return withhold(checks, reasons_unrankable(places))


def w18(evidence: Evidence, *, min_depth: float) -> list[Check]:
    """The slowest flow: the least shear above any height, relative to that below it.

    A plug has less than 5 % there (W11). The ratio of the least to the largest du/dz is reported.
    """
    flows = select_replicated(base_flows(evidence, min_depth))
    if len(flows) < 3:
        raise Untestable(f"fewer than three flows with n ≥ {min_depth} that have replicates")
    n, place = min(flows.items(), key=lambda flow: flow[1].velocity.nominal_value)

    def stiffest(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        shear = layers.relative_shear(height, velocity, packing, place["diameter"])[1]
        return min(shear, default=inf)

    shear, even = (place.measure(measure, *PROFILES) for measure in (stiffest, _evenness(place)))
    quantity = f"least shear above a height over that below it, n = {n:g}"
    checks = [
        above(quantity, shear, layers.PLUG_SHEAR, [place]),
        reported(f"least over largest du/dz, n = {n:g}", even, [place]),
    ]
    return withhold_unsettled(checks, [place])


def _shallow_flows(evidence: Evidence, max_depth: float) -> dict[float, Place]:
    """Return the flows from one layer to less than ``max_depth`` that have many replicates."""
    flows = {n: place for n, place in base_flows(evidence, 1).items() if n < max_depth}
    replicated_flows = select_replicated(flows, MIN_REPLICATES)
    if not replicated_flows:
        raise Untestable(f"no flow with 1 ≤ n < {max_depth:g} that has {MIN_REPLICATES} replicates")
    return replicated_flows


def _steps(
    place: Place,
    name: str,
    lowest: float = 0.0,
    scale: float | None = None,
    min_mass_share: float = MIN_MASS_SHARE,
) -> np.ndarray:
    """Return the steps (R, B) of a profile between slices with enough mass, over ``scale``.

    Without a scale they are divided by the heights: slopes. Slices below ``lowest`` (m) do not
    count.
    """
    (rows, height), (packing, _) = place.profile(name), place.profile("packing_profile")
    mean = packing.mean(axis=0)
    is_counted = (mean > min_mass_share * mean.sum()) & (height >= lowest)
    return np.diff(rows[:, is_counted], axis=1) / (scale or np.diff(height[is_counted]))


def _layer_packing(place: Place) -> np.ndarray:
    """Return the packing by layers of a diameter (R, L), of layers that all replicates have."""
    packing, height = place.profile("packing_profile")
    rows = [layers.packing_by_diameters(height, row, place["diameter"]) for row in packing]
    return np.array([row[: min(map(len, rows))] for row in rows])


def _evenness(place: Place) -> Callable[..., float]:
    """Return a function of profiles: the ratio of the least to the largest mean du/dz.

    The means are over a diameter, because a slice shares its spheres with its neighbors.
    """

    def evenness(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        across = round(place["diameter"] / (height[1] - height[0]))
        dense = velocity[packing > MIN_MASS_SHARE * packing.sum()]
        slopes = dense[across:] - dense[:-across]
        rises = slopes.size > 1 and slopes.max() > 0
        return slopes.min() / slopes.max() if rises else np.nan

    return evenness


def _plug_measure(
    place: Place, function: Callable[[np.ndarray, float], float]
) -> Callable[..., float]:
    """Return a function of profiles, which applies ``function`` to plug and shear layer.

    ``function`` gets the packing by layers of the plug and the mean packing of the shear layer. The
    layers are two diameters thick, as layers of a crystal are not a diameter apart. The gap under
    the centres of the lowest spheres belongs to no layer.
    """
    diameter = place["diameter"]

    def measure(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        depth = layers.shear_depth(height, velocity, packing, diameter)
        rows = layers.packing_by_diameters(height, packing, diameter, layers=2)
        plug = rows[2 * diameter * np.arange(len(rows)) >= depth]
        sheared = packing[(height >= 0.5 * diameter) & (height < depth)]
        return function(plug, sheared.mean()) if plug.size and sheared.size else np.nan

    return measure
