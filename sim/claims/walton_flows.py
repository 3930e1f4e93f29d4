"""Judges of Walton's claims about mean velocities, regimes and forces of the flows."""

import numpy as np

from sim.claims.evidence import Evidence
from sim.claims.verdict import Check, Untestable, within

#: Largest relative deviations of shear/normal from tan θ, and of the normal force from N m g cos θ.
RATIO, NORMAL = 0.005, 0.002


def w26(evidence: Evidence) -> list[Check]:
    """Base forces of all steady flows of the base case against their weight."""
    checks = []
    for depth, place in evidence.line("chute", "depth").items():
        if place.regime != "steady":
            continue
        angle = np.radians(place["angle"])
        normal = place.value("base_normal", "base_normal_error")
        shear = place.value("base_shear", "base_shear_error")
        weight = place["particles"] * place["mass"] * place["gravity"]
        ratio = shear / normal / np.tan(angle) - 1
        pressed = normal / (weight * np.cos(angle)) - 1
        at = f"n = {depth:g}"
        checks.append(
            within(f"shear/normal over tan θ, less 1, {at}", ratio, -RATIO, RATIO, [place])
        )
        checks.append(
            within(f"normal over N m g cos θ, less 1, {at}", pressed, -NORMAL, NORMAL, [place])
        )
    if not checks:
        raise Untestable("no steady flow of the base case")
    return checks
