"""Judges of Gallas' claims about the paths of the beads over one cycle."""

from math import pi, sqrt

import numpy as np
from uncertainties import UFloat, umath

from sim.claims.checks import above, below, judge_parts, reported, within
from sim.claims.evidence import Evidence
from sim.claims.inference import outranks, trend
from sim.claims.lines import complete_line
from sim.claims.place import Place
from sim.claims.verdict import Check, Untestable

#: Diameter (⟨d⟩) of the obstacle of Fig. 7.
OBSTACLE = 1.5

#: A closed path has a drift below this share of its long axis, or of its height.
MAX_CLOSED_DRIFT = 0.1

#: Length of the axis of an ellipse over the rms extent along it.
AXIS_OVER_RMS = 2 * sqrt(2)

#: Least ratio of short to long axis of a path that differs from a line.
MIN_AXIS_RATIO = 0.05

#: Tilt (degrees) from which a path counts as vertical.
MIN_STEEP_TILT = 75


def height_over_drift(place: Place) -> UFloat:
    """Return the vertical rms extent of the paths over their drift; it is small for a stream."""
    return place.value("path_vertical") / place.value("path_drift")


def tilt(place: Place) -> UFloat:
    """Return the angle (degrees) of the long axis of the mean path with the horizontal."""
    return place.value("path_tilt") * (180 / pi)


def check_steep(place: Place, quantity: str) -> Check:
    """Return the check that the mean path is nearly vertical."""
    return within(quantity, tilt(place), MIN_STEEP_TILT, 180 - MIN_STEEP_TILT, (place,), "degree")


def check_more_tilted(steeper: Place, flatter: Place, quantity: str) -> Check:
    """Return the check that the mean path is more tilted at one place than at another."""
    return above(quantity, tilt(steeper) - tilt(flatter), 0, (steeper, flatter), "degree")


def g24(evidence: Evidence) -> list[Check]:
    """Fig. 4, from drift, axes, tilt and height of the paths.

    At 10 Hz paths are ellipses (a), upright where shear friction is small (b). They are sinusoids
    at 20 Hz and a stream at 80 Hz (c), and go up and down without shear friction (d).
    """
    return judge_parts(
        a=lambda: _ellipses(evidence),
        b=lambda: _upright(evidence),
        c=lambda: _sinusoids(evidence),
        d=lambda: _up_and_down(evidence),
    )


def _ellipses(evidence: Evidence) -> list[Check]:
    """Check for closed paths (drift over long axis), no lines, tilted with the vibration."""
    line = complete_line(evidence, "vibration_angle", (45, 60), frequency=10)
    ellipse, steeper = line.values()
    closed = ellipse.value("path_drift") / (AXIS_OVER_RMS * ellipse.value("path_major"))
    axes = ellipse.value("path_minor") / ellipse.value("path_major")
    return [
        below("drift per cycle over the long axis, 10 Hz", closed, MAX_CLOSED_DRIFT, (ellipse,)),
        above("short over long axis, 10 Hz", axes, MIN_AXIS_RATIO, (ellipse,)),
        check_more_tilted(steeper, ellipse, "tilt at 60 less that at 45 degrees, 10 Hz"),
    ]


def _upright(evidence: Evidence) -> list[Check]:
    ellipse = evidence.at("belt", frequency=10)
    sliding = evidence.at("belt", frequency=10, shear_damping=1)
    return [
        check_more_tilted(sliding, ellipse, "tilt at γ_s = g less that at 50g, 10 Hz"),
        check_steep(sliding, "tilt at γ_s = g, 10 Hz"),
    ]


def _sinusoids(evidence: Evidence) -> list[Check]:
    """Check for paths that drift, and are higher for their drift than those of the stream."""
    sinusoid, stream = complete_line(evidence, "frequency", (20, 80)).values()
    drift = sinusoid.value("path_drift") * 1e3
    flatter = height_over_drift(sinusoid) - height_over_drift(stream)
    quantity = "height of the paths over their drift, 20 Hz less 80 Hz"
    return [
        above("drift per cycle, 20 Hz", drift, 0, (sinusoid,), "mm"),
        above(quantity, flatter, 0, (sinusoid, stream)),
    ]


def _up_and_down(evidence: Evidence) -> list[Check]:
    place = evidence.at("belt", frequency=80, shear_damping=0)
    drift = place.value("path_drift") / place.value("path_vertical")
    return [
        below(
            "drift per cycle over the rms height, γ_s = 0, 80 Hz", drift, MAX_CLOSED_DRIFT, (place,)
        ),
        check_steep(place, "tilt at γ_s = 0, 80 Hz"),
    ]


def g25(evidence: Evidence) -> list[Check]:
    """At 80 Hz paths are lower for their drift at smaller angles (a) and with more friction (b)."""
    return judge_parts(a=lambda: _flatter_angles(evidence), b=lambda: _flatter_friction(evidence))


def _flatter_angles(evidence: Evidence) -> list[Check]:
    line = complete_line(evidence, "vibration_angle", (30, 45, 60), frequency=80)
    groups = [_heights_over_drift(place) for place in line.values()]
    quantity = "height of the paths over their drift, over α = 30, 45, 60 degrees"
    return [trend(quantity, [groups], line.values())]


def _flatter_friction(evidence: Evidence) -> list[Check]:
    loose = evidence.at("belt", frequency=80, damping=10, shear_damping=10)
    usual = evidence.at("belt", frequency=80)
    quantity = "share of pairs higher for their drift with 10g than with 50g"
    return [
        outranks(quantity, _heights_over_drift(loose), _heights_over_drift(usual), (loose, usual))
    ]


def _heights_over_drift(place: Place) -> np.ndarray:
    """Return the vertical rms extent of the paths over their drift per bed, (R,)."""
    return place.values("path_vertical") / place.values("path_drift")


def g32(evidence: Evidence) -> list[Check]:
    """Behind an obstacle the paths at 80 Hz are nearer to those at 20 Hz than to those at 80 Hz.

    The distance is measured in ln(height over drift): 0 is 80 Hz without obstacle, 1 is 20 Hz. The
    height alone is not the shape of a path, so it is reported only.
    """
    places = (
        evidence.at("belt", frequency=80, obstacle=OBSTACLE),
        evidence.at("belt", frequency=80),
        evidence.at("belt", frequency=20),
    )
    if not all(height_over_drift(place).nominal_value > 0 for place in places):
        raise Untestable("a bed drifts backwards at 20 or 80 Hz, or behind the obstacle")
    blocked, fast, slow = (umath.log(height_over_drift(place)) for place in places)
    change = (blocked - fast) / (slow - fast)
    quantity = "height over drift of the paths on the way from 80 to 20 Hz"
    heights = [umath.log(place.value("path_vertical")) for place in places]
    taller = (heights[0] - heights[1]) / (heights[2] - heights[1])
    return [
        above(quantity, change, 0.5, places),
        reported("height alone of the paths on the way from 80 to 20 Hz", taller, places),
    ]
