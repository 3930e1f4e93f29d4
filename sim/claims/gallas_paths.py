"""Judges of Gallas' claims about the paths of the beads over one cycle."""

from itertools import pairwise
from math import pi, sqrt

from uncertainties import UFloat, umath

from sim.claims.checks import above, within
from sim.claims.evidence import Evidence
from sim.claims.lines import along
from sim.claims.place import Place
from sim.claims.verdict import Check, Untestable

#: Diameter (⟨d⟩) of the obstacle of Fig. 7.
OBSTACLE = 1.5

#: A path that comes round has a drift below this share of its long axis, or of its height.
CLOSED = 0.1

#: Length of the axis of an ellipse over the rms extent along it.
FULL = 2 * sqrt(2)

#: Short over long axis of a path that can be told from a line.
OVAL = 0.05

#: Tilt (degrees) from which a path counts as vertical.
STEEP = 75


def height_over_drift(place: Place) -> UFloat:
    """Return the vertical rms extent of the paths over their drift: small for a stream."""
    return place.value("path_vertical") / place.value("path_drift")


def tilt(place: Place) -> UFloat:
    """Return the angle (degrees) of the long axis of the mean path with the horizontal."""
    return place.value("path_tilt") * (180 / pi)


def steep(place: Place, what: str) -> Check:
    """Return the check that the mean path is nearly vertical."""
    return within(what, tilt(place), STEEP, 180 - STEEP, (place,), "degree")


def more_tilted(one: Place, other: Place, what: str) -> Check:
    """Return the check that the mean path is more tilted at one place than at another."""
    return above(what, tilt(one) - tilt(other), 0, (one, other), "degree")


def g24(evidence: Evidence) -> list[Check]:
    """Fig. 4, panel by panel, from drift, axes, tilt and height of the paths.

    a: closed (the drift against the whole long axis), not a line, and more tilted with a steeper
    vibration; b: still more tilted, by more than 75 degrees; c: drifting, and higher for their
    drift than d; e: no drift to speak of, vertical.
    """
    ellipse, sinusoid, stream = along(evidence, "frequency", (10, 20, 80)).values()
    steeper = evidence.at("belt", frequency=10, vibration_angle=60)
    sliding = evidence.at("belt", frequency=10, shear_damping=1)
    vertical = evidence.at("belt", frequency=80, shear_damping=0)
    drift = {place: place.value("path_drift") for place in (ellipse, sinusoid, vertical)}
    closed = drift[ellipse] / (FULL * ellipse.value("path_major"))
    axes = ellipse.value("path_minor") / ellipse.value("path_major")
    flatter = height_over_drift(sinusoid) - height_over_drift(stream)
    still = drift[vertical] / vertical.value("path_vertical")
    return [
        within("a: drift per cycle over the long axis", closed, -CLOSED, CLOSED, (ellipse,)),
        above("a: short over long axis", axes, OVAL, (ellipse,)),
        more_tilted(steeper, ellipse, "a: tilt at 60 less that at 45 degrees"),
        more_tilted(sliding, ellipse, "b less a: tilt"),
        steep(sliding, "b: tilt at γ_s = g"),
        above("c: drift per cycle", drift[sinusoid] * 1e3, 0, (sinusoid,), "mm"),
        above("c less d: height of the paths over their drift", flatter, 0, (sinusoid, stream)),
        within(
            "e: drift per cycle over the rms height of the paths",
            still,
            -CLOSED,
            CLOSED,
            (vertical,),
        ),
        steep(vertical, "e: tilt"),
    ]


def g25(evidence: Evidence) -> list[Check]:
    """At 80 Hz paths are lower for their drift at smaller angles and with more friction."""
    angles = along(evidence, "vibration_angle", (30, 45, 60), frequency=80)
    pairs = {
        f"({damping}g, {shear}g)": evidence.at(
            "belt", frequency=80, damping=damping, shear_damping=shear
        )
        for damping, shear in ((50, 100), (50, 50), (10, 10))
    }
    named = {f"{angle} degrees": place for angle, place in angles.items()}
    return [*_flatter(named), *_flatter(pairs)]


def _flatter(line: dict[str, Place]) -> list[Check]:
    """Return checks that paths get higher for their drift from place to place."""
    return [
        above(
            f"height of the paths over their drift at {high} less {low}",
            height_over_drift(line[high]) - height_over_drift(line[low]),
            0,
            (line[high], line[low]),
        )
        for low, high in pairwise(line)
    ]


def g32(evidence: Evidence) -> list[Check]:
    """Behind an obstacle the paths at 80 Hz are nearer to those at 20 Hz than to those at 80 Hz.

    Nearer in the logarithm of height over drift, and in that of the height alone: 0 is as at 80 Hz
    without obstacle, 1 as at 20 Hz.
    """
    places = (
        evidence.at("belt", frequency=80, obstacle=OBSTACLE),
        evidence.at("belt", frequency=80),
        evidence.at("belt", frequency=20),
    )
    checks = []
    for what, measure in (
        ("height over drift", height_over_drift),
        ("height", lambda place: place.value("path_vertical")),
    ):
        values = [measure(place) for place in places]
        if not all(value.nominal_value > 0 for value in values):
            raise Untestable("a bed drifts backwards at 20 or 80 Hz, or behind the obstacle")
        blocked, fast, slow = (umath.log(value) for value in values)
        change = (blocked - fast) / (slow - fast)
        what = f"{what} of the paths on the way from 80 to 20 Hz"
        checks.append(above(what, change, 0.5, places))
    return checks
