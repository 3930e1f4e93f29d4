"""Judges of Gallas' claims about the paths of the beads over one cycle, and the fixed obstacle."""

from math import pi, sqrt

import numpy as np
from uncertainties import UFloat, umath

from sim.claims.checks import Numbers, Pair, above, below, judge_parts, reported, within
from sim.claims.evidence import Evidence
from sim.claims.inference import outranks, reported_order, trend
from sim.claims.place import Place, quotient, replicate_mean
from sim.claims.verdict import Check, Untestable
from sim.measures.belt import FAR_DISTANCE
from sim.papers.gallas.judges.lines import bed, common_beds, complete_line, velocity_trend

#: Length of the axis of an ellipse over the rms extent along it.
AXIS_OVER_RMS = 2 * sqrt(2)


def height_over_drift(place: Place) -> UFloat:
    """Return the vertical rms extent of the paths over their drift; it is small for a stream."""
    return place.value("path_vertical") / place.value("path_drift")


def tilt(place: Place) -> UFloat:
    """Return the angle (degrees) of the long axis of the mean path with the horizontal."""
    return place.value("path_tilt") * (180 / pi)


def check_steep(place: Place, quantity: str, min_tilt: float) -> Check:
    """Return the check that the mean path is tilted by ``min_tilt`` (degrees) either way."""
    return within(quantity, tilt(place), min_tilt, 180 - min_tilt, (place,), "degree")


def check_more_tilted(steeper: Place, flatter: Place, quantity: str) -> Check:
    """Return the check that the mean path is more tilted at one place than at another."""
    return above(quantity, tilt(steeper) - tilt(flatter), 0, (steeper, flatter), "degree")


def g24(
    evidence: Evidence,
    *,
    slow: float,
    max_drift: float,
    min_axis_ratio: float,
    angles: Pair,
    min_tilt: float,
    frequencies: Pair,
) -> list[Check]:
    """Fig. 4, from drift, axes, tilt and height of the paths; frequencies in Hz, angles in degrees.

    At a slow frequency they are ellipses (a), upright where shear friction is small (b). They are
    sinusoids and a stream at two others (c), and go up and down without shear friction (d).
    """
    return judge_parts(
        a=lambda: _ellipses(evidence, slow, angles, max_drift, min_axis_ratio),
        b=lambda: _upright(evidence, slow, min_tilt),
        c=lambda: _sinusoids(evidence, frequencies),
        d=lambda: _up_and_down(evidence, max_drift, min_tilt),
    )


def _ellipses(
    evidence: Evidence, frequency: float, angles: Pair, max_drift: float, min_axis_ratio: float
) -> list[Check]:
    line = complete_line(evidence, "vibration_angle", angles, frequency=frequency)
    ellipse, steeper = line.values()
    usual, steep = angles
    tilted = f"tilt at {steep} less that at {usual} degrees, {frequency} Hz"
    closed = ellipse.value("path_drift") / (AXIS_OVER_RMS * ellipse.value("path_major"))
    axes = ellipse.value("path_minor") / ellipse.value("path_major")
    return [
        below(f"drift per cycle over the long axis, {frequency} Hz", closed, max_drift, (ellipse,)),
        above(f"short over long axis, {frequency} Hz", axes, min_axis_ratio, (ellipse,)),
        check_more_tilted(steeper, ellipse, tilted),
    ]


def _upright(evidence: Evidence, frequency: float, min_tilt: float) -> list[Check]:
    ellipse = bed(evidence, frequency)
    sliding = bed(evidence, frequency, shear_damping=1)
    more_tilted = f"tilt at γ_s = g less that at 50g, {frequency} Hz"
    return [
        check_more_tilted(sliding, ellipse, more_tilted),
        check_steep(sliding, f"tilt at γ_s = g, {frequency} Hz", min_tilt),
    ]


def _sinusoids(evidence: Evidence, frequencies: Pair) -> list[Check]:
    """Check for paths that drift, and are higher for their drift than those of the stream."""
    sinusoid, stream = complete_line(evidence, "frequency", frequencies).values()
    drift = sinusoid.value("path_drift") * 1e3
    flatter = height_over_drift(sinusoid) - height_over_drift(stream)
    quantity = "height of the paths over their drift, {} Hz less {} Hz".format(*frequencies)
    return [
        above(f"drift per cycle, {frequencies[0]} Hz", drift, 0, (sinusoid,), "mm"),
        above(quantity, flatter, 0, (sinusoid, stream)),
    ]


def _up_and_down(evidence: Evidence, max_drift: float, min_tilt: float) -> list[Check]:
    place = bed(evidence, 80, shear_damping=0)
    drift = place.value("path_drift") / place.value("path_vertical")
    return [
        below("drift per cycle over the rms height, γ_s = 0, 80 Hz", drift, max_drift, (place,)),
        check_steep(place, "tilt at γ_s = 0, 80 Hz", min_tilt),
    ]


def g25(
    evidence: Evidence, *, frequency: float, angles: Numbers, loose: Pair, usual: Pair
) -> list[Check]:
    """Paths are lower for their drift at smaller angles (a) and with more friction (b).

    ``loose`` and ``usual`` are damping and shear damping (g).
    """

    def at_angles() -> list[Check]:
        line = complete_line(evidence, "vibration_angle", angles, frequency=frequency)
        groups = [_heights_over_drift(place) for place in line.values()]
        values = ", ".join(map(str, angles))
        quantity = f"height of the paths over their drift, over α = {values} degrees"
        return [trend(quantity, [groups], line.values())]

    def with_friction() -> list[Check]:
        places = [
            bed(evidence, frequency, damping=damping, shear_damping=shear)
            for damping, shear in (loose, usual)
        ]
        quantity = f"share of pairs higher for their drift with {loose[0]}g than with {usual[0]}g"
        first, second = map(_heights_over_drift, places)
        return [outranks(quantity, first, second, places)]

    return judge_parts(a=at_angles, b=with_friction)


def _heights_over_drift(place: Place) -> np.ndarray:
    """Return the vertical rms extent of the paths over their drift per bed, (R,)."""
    return place.values("path_vertical") / place.values("path_drift")


def g32(evidence: Evidence, *, fast: float, slow: float, obstacle: float) -> list[Check]:
    """Behind an obstacle (⟨d⟩) paths at a fast frequency (Hz) are nearer to those at a slow one.

    The distance is measured in ln(height over drift): 0 is fast without obstacle, 1 is slow. The
    height alone is not the shape of a path, so it is reported only.
    """
    places = bed(evidence, fast, obstacle=obstacle), bed(evidence, fast), bed(evidence, slow)
    if not all(height_over_drift(place).nominal_value > 0 for place in places):
        raise Untestable(f"a bed drifts backwards at {slow} or {fast} Hz, or behind the obstacle")
    shapes = [umath.log(height_over_drift(place)) for place in places]
    heights = [umath.log(place.value("path_vertical")) for place in places]
    change, taller = (
        (blocked - free) / (other - free) for blocked, free, other in (shapes, heights)
    )
    way = f"of the paths on the way from {fast} to {slow} Hz"
    return [
        above(f"height over drift {way}", change, 0.5, places),
        reported(f"height alone {way}", taller, places),
    ]


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
