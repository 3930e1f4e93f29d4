"""Judges of Gallas' claims about the paths of the beads over one cycle."""

from math import pi, sqrt

import numpy as np
from uncertainties import UFloat, umath

from sim.claims.checks import Numbers, Pair, above, below, judge_parts, reported, within
from sim.claims.evidence import Evidence
from sim.claims.inference import outranks, trend
from sim.claims.place import Place
from sim.claims.verdict import Check, Untestable
from sim.papers.gallas.judges.lines import bed, complete_line

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
    """Fig. 4, from drift, axes, tilt and height of the paths.

    At a slow frequency (Hz) paths are ellipses (a), upright where shear friction is small (b). They
    are sinusoids at the first of two frequencies and a stream at the second (c), and go up and down
    without shear friction (d). A closed path drifts by less than ``max_drift`` of its long axis or
    height, and is no line from ``min_axis_ratio`` on.
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
