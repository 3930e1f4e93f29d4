"""Judges of Gallas' claims about the fixed obstacle."""

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import Numbers, above, below, reported
from sim.claims.evidence import Evidence
from sim.claims.inference import reported_order
from sim.claims.place import Place, quotient, replicate_mean
from sim.claims.verdict import Check
from sim.measures.belt import FAR_DISTANCE
from sim.papers.gallas.judges.lines import bed, common_beds, complete_line, velocity_trend


def g31(
    evidence: Evidence, *, obstacles: Numbers, frequencies: Numbers, max_ratio: float
) -> list[Check]:
    """Each larger obstacle (⟨d⟩) slows the flow further, and the smallest to ``max_ratio`` of V."""
    checks = []
    for frequency in frequencies:
        line = complete_line(evidence, "obstacle", obstacles, frequency=frequency)
        checks.append(velocity_trend(line, f"d_o (⟨d⟩), {frequency} Hz,", rising=False))
        groups = [place.values("velocity") for place in line.values()]
        order = f"V falls over d_o at {frequency} Hz"
        checks.append(reported_order(order, [groups], rising=False))
        free, small = obstacles[:2]
        places = line[small], line[free]
        ratio = quotient(*(place.velocity for place in places))
        quantity = f"V(d_o = {small}⟨d⟩)/V({free}) at {frequency} Hz"
        checks.append(below(quantity, ratio, max_ratio, places))
    return checks


def g33(
    evidence: Evidence, *, max_share: float, obstacles: Numbers, frequency: float
) -> list[Check]:
    """Less than ``max_share`` of the beads is where the mean flow runs backwards."""
    line = complete_line(evidence, "obstacle", obstacles, frequency=frequency)
    return [
        below(
            f"share of the beads where the mean flow runs backwards, d_o = {size:g}⟨d⟩",
            place.value("backflow"),
            max_share,
            (place,),
        )
        for size, place in line.items()
    ]


def g34(evidence: Evidence, *, min_share: float, frequencies: Numbers) -> list[Check]:
    """Far from an obstacle paths change their shape by ``min_share`` or more of the overall change.

    The shape is the height over the drift. The share of the slow-down there is reported: the flux
    is the same through all columns.
    """
    checks = []
    for frequency in frequencies:
        places = bed(evidence, frequency), bed(evidence, frequency, obstacle=1.5)
        quantity = (
            f"change of ln(height over drift) beyond {FAR_DISTANCE}⟨d⟩ less {min_share:.0%} "
            f"of that of all, {frequency} Hz"
        )
        slowed = f"share of the slow-down beyond {FAR_DISTANCE}⟨d⟩ at {frequency} Hz"
        checks += [
            above(quantity, far_shape_change(*places, min_share), 0, places),
            reported(slowed, far_slow_down(*places), places),
        ]
    return checks


def far_slow_down(free: Place, blocked: Place) -> UFloat:
    """Return the share of the slow-down that lies in columns far from the obstacle.

    It is computed bed by bed. Without an obstacle all columns are alike, so their mean is used.
    """
    first, second = common_beds((free, blocked))
    before = free.profile("column_velocity")[0][first].mean(axis=1)
    after, far = blocked.profile("column_velocity")[0], _is_far(blocked)
    beyond, overall = after[second][:, far].mean(axis=1), after[second].mean(axis=1)
    return replicate_mean(far.mean() * (before - beyond) / (before - overall))


def far_shape_change(free: Place, blocked: Place, min_share: float) -> UFloat:
    """Return the far change of ln(height over drift) less ``min_share`` of the overall change.

    The sign of the overall change counts as positive. The drift of the far paths is that of the
    columns there; without an obstacle all columns are alike.
    """
    first, second = common_beds((free, blocked))
    heights = [
        np.log(blocked.values(name)[second] / free.values(name)[first])
        for name in ("path_vertical", "path_vertical_far")
    ]
    before = free.profile("column_velocity")[0][first].mean(axis=1)
    after, far = blocked.profile("column_velocity")[0][second], _is_far(blocked)
    drifts = [np.log(velocities.mean(axis=1) / before) for velocities in (after, after[:, far])]
    everywhere, beyond = (height - drift for height, drift in zip(heights, drifts, strict=True))
    return replicate_mean(np.sign(everywhere.mean()) * (beyond - min_share * everywhere))


def _is_far(blocked: Place) -> np.ndarray:
    column = blocked.profile("column_velocity")[1]
    width = blocked["width"] * blocked["diameter"]
    return np.abs(column - 0.5 * width) > FAR_DISTANCE * blocked["diameter"]
