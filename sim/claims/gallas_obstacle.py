"""Judges of Gallas' claims about the fixed obstacle."""

import numpy as np
from uncertainties import UFloat

from sim.claims.evidence import Evidence, joined
from sim.claims.lines import along, increases
from sim.claims.verdict import Check, above, below

#: Frequencies (Hz) of Fig. 6.
FREQUENCIES = (20, 80)

#: Distance (⟨d⟩) from the obstacle beyond which its effect is no longer local.
FAR = 5


def g31(evidence: Evidence) -> list[Check]:
    """Each larger obstacle slows the flow further, and one of half a bead takes 30 % of it."""
    checks = []
    for frequency in FREQUENCIES:
        line = along(evidence, "obstacle", (0, 0.5, 1.5, 2.5), frequency=frequency)
        checks += increases(line, f"{frequency} Hz, d_o (⟨d⟩)", -1)
        ratio = line[0.5].velocity / line[0].velocity
        places = line[0.5], line[0]
        checks.append(below(f"V(d_o = 0.5⟨d⟩)/V(0) at {frequency} Hz", ratio, 0.7, places))
    return checks


def g33(evidence: Evidence) -> list[Check]:
    """At 80 Hz less than 1 % of the beads are where the mean flow runs backwards."""
    return [
        below(
            f"share of the beads where the mean flow runs backwards, d_o = {size:g}⟨d⟩",
            place.value("backflow"),
            0.01,
            (place,),
        )
        for size, place in along(evidence, "obstacle", (1.5, 2.5), frequency=80).items()
    ]


def g34(evidence: Evidence) -> list[Check]:
    """More than 30 % of the slow-down by an obstacle of 1.5⟨d⟩ is further than 5⟨d⟩ from it."""
    checks = []
    for frequency in FREQUENCIES:
        free = evidence.at("belt", frequency=frequency)
        blocked = evidence.at("belt", frequency=frequency, obstacle=1.5)
        before, after = (place.profile("column_velocity")[0] for place in (free, blocked))
        column = blocked.profile("column_velocity")[1]
        width = blocked["width"] * blocked["diameter"]
        far = np.abs(column - 0.5 * width) > FAR * blocked["diameter"]
        what = f"share of the slow-down beyond 5⟨d⟩ at {frequency} Hz"
        checks.append(above(what, far_share(before, after, far), 0.3, (free, blocked)))
    return checks


def far_share(before: np.ndarray, after: np.ndarray, far: np.ndarray) -> UFloat:
    """Return the share of the slow-down that lies in columns far from the obstacle.

    ``before`` and ``after`` are velocities (R, C) per bed and column. Without obstacle all columns
    are alike, so their mean counts, which is the same for all of them.
    """
    free = joined(before.mean(axis=1))
    beyond, overall = joined(after[:, far].mean(axis=1)), joined(after.mean(axis=1))
    return far.mean() * (free - beyond) / (free - overall)
