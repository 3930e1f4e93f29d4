"""Judges of how Walton says that flows work: rolling, losses by height, encounters."""

from dataclasses import replace
from functools import partial

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import (
    Numbers,
    above,
    at_least,
    below,
    judge_parts,
    remove_votes,
    reported,
    withhold,
)
from sim.claims.evidence import Evidence
from sim.claims.inference import smallest_mean, trend
from sim.claims.place import Place, replicate_mean, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.measures import layers
from sim.papers.walton.judges.chute import (
    base_flows,
    depth_label,
    flows_of_one_age,
    lost_share,
    majority_if_mixed,
    reason_incomparable,
    reasons_unrankable,
    stiffness_suffix,
    waive_samples,
    withhold_unsettled,
)

#: Profiles of what is lost, power per volume.
LOSSES = ("normal_dissipation_profile", "frictional_dissipation_profile")


def w29(
    evidence: Evidence, *, depths: Numbers, cell: float, most: float, slight: float
) -> list[Check]:
    """Spin times radius over velocity of the spheres at the plane, at several depths of one age.

    It exceeds ``most``, each depth a part, and at no depth lacks ``slight`` of one (d). ``cell`` is
    in diameters.
    """
    flows = flows_of_one_age(evidence, [{"depth": n, "cell": cell} for n in depths])
    if not all(np.isfinite(place.values("base_rolling")).all() for place in flows):
        raise Untestable("flows whose spins were not recorded")
    checks = []
    for parts, least in (("abc", most), ("ddd", 1 - slight)):
        for part, place in zip(parts, flows, strict=True):
            quantity = f"spin times radius over velocity at the plane, {depth_label(place)}"
            check = above(quantity, place.value("base_rolling"), least, [place])
            check = majority_if_mixed(check, place, place.values("base_rolling"))
            checks.append(replace(check, part=part))
    return withhold(withhold_unsettled(checks, flows), reason_incomparable(flows))


def w30(
    evidence: Evidence, *, share: float, depths: Numbers, cell: float, stiffness: float
) -> list[Check]:
    """Trend over the depths of the part of the bed below the height that has most of the loss.

    The flows are those of one ``cell`` (σ), one age and one ``stiffness`` (N/m).
    """
    wheres = [{"depth": n, "cell": cell} for n in depths]
    places = flows_of_one_age(evidence.with_reading(stiffness=stiffness), wheres)
    groups = [
        place.measure_replicates(partial(_losing_part, share=share), *LOSSES, "packing_profile")
        for place in places
    ]
    quantity = f"part of the bed with {100 * share:g} % of the loss"
    label = f"{', '.join(f'{n:g}' for n in depths)}{stiffness_suffix(places[-1])}"
    check = trend(f"{quantity}, over n = {label}", [groups], places, rising=False)
    return [
        *withhold([check], reasons_unrankable(places)),
        *(
            reported(f"{quantity}, {depth_label(place)}", replicate_mean(group), [place])
            for place, group in zip(places, groups, strict=True)
        ),
    ]


def _losing_part(
    height: np.ndarray,
    collisions: np.ndarray,
    friction: np.ndarray,
    packing: np.ndarray,
    share: float,
) -> float:
    """Return the part of the spheres below the height below which a share of the loss lies."""
    top = layers.level(height, collisions + friction, share)
    tops = height + 0.5 * (height[1] - height[0])
    return float(np.interp(top, tops, np.cumsum(packing)) / packing.sum())


def w31(
    evidence: Evidence, *, variety: int, min_depth: float, margin: float, min_share: float
) -> list[Check]:
    """Velocity (a) and packing (b) by layers at the end of the window less those over the window.

    At ``variety`` depths or more none differs by ``margin`` of the largest. Layers count that have
    ``min_share`` of the spheres of the fullest.
    """
    flows = select_replicated(base_flows(evidence, min_depth))
    if len(flows) < variety:
        raise Untestable(f"fewer than {variety} flows with n ≥ {min_depth} that have replicates")

    def steady(name: str, of: str) -> list[Check]:
        checks = [
            below(
                f"largest change of a layer's {of}, n = {n:g}",
                margin - _least_room(place, name, min_share, margin),
                margin,
                [place],
            )
            for n, place in flows.items()
        ]
        return [
            at_least(f"depths of a steady {of} profile", variety, checks),
            *remove_votes(checks),
        ]

    return judge_parts(
        a=partial(steady, "velocity_profile", "velocity"),
        b=partial(steady, "packing_profile", "packing"),
    )


def _least_room(place: Place, name: str, min_share: float, margin: float) -> UFloat:
    """Return the least that a margin leaves of the changes of all layers, for all at once.

    Changes are from the mean over the window to its end, relative to the largest layer.
    """
    (window, height), (end, _) = (place.profile(f"{name}{of}") for of in ("", "_instantaneous"))
    packings = [place.profile(f"packing_profile{of}")[0] for of in ("", "_instantaneous")]
    number = np.floor(height / place["diameter"]).astype(int)
    mass = np.bincount(number, packings[0].mean(axis=0))
    counted = np.flatnonzero(mass > min_share * mass.max())

    def by_layers(rows: np.ndarray, packing: np.ndarray) -> np.ndarray:
        weights = packing if name == "velocity_profile" else np.ones_like(packing)
        values = np.where(weights > 0, rows, 0.0)
        sums = [
            [(array[:, number == layer]).sum(axis=1) for layer in counted]
            for array in (values * weights, weights)
        ]
        return np.divide(*map(np.array, sums)).T

    before, after = (
        by_layers(rows, packing) for rows, packing in zip((window, end), packings, strict=True)
    )
    change = (after - before) / before.mean(axis=0).max()
    return smallest_mean(np.hstack([margin - change, margin + change]))


def w32(evidence: Evidence, *, max_share: float) -> list[Check]:
    """What a flow of half a layer loses, over the power of gravity."""
    place = evidence.at("chute", depth=0.5)
    if place.completed < 2:
        raise Untestable("no flow at n = 0.5 that has replicates")
    share = replicate_mean(lost_share(place))
    check = below("power lost over that of gravity, n = 0.5", share, max_share, [place])
    return [waive_samples(check, place)]
