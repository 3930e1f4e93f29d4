"""Judges of Gallas' claims about the fixed obstacle."""

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import above, below
from sim.claims.evidence import Evidence
from sim.claims.lines import along, common_beds, increases
from sim.claims.place import Place, joined, quotient
from sim.claims.verdict import Check
from sim.dataset.measures.belt import FAR

#: Frequencies (Hz) of Fig. 6.
FREQUENCIES = (20, 80)

#: Share of an effect that must be seen far away for it to be more than local.
SPREAD = 0.3


def g31(evidence: Evidence) -> list[Check]:
    """Each larger obstacle slows the flow further, and one of half a bead takes 30 % of it."""
    checks = []
    for frequency in FREQUENCIES:
        line = along(evidence, "obstacle", (0, 0.5, 1.5, 2.5), frequency=frequency)
        checks += increases(line, f"{frequency} Hz, d_o (⟨d⟩)", -1)
        ratio = quotient(line[0.5].velocity, line[0].velocity)
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
    """More than 30 % of what an obstacle of 1.5⟨d⟩ does is further than 5⟨d⟩ from it.

    That is the slow-down, and the change of the height of the paths: the flux is the same through
    all columns, but no balance makes the heights alike.
    """
    checks = []
    for frequency in FREQUENCIES:
        places = (
            evidence.at("belt", frequency=frequency),
            evidence.at("belt", frequency=frequency, obstacle=1.5),
        )
        slowed = above(
            f"share of the slow-down beyond {FAR}⟨d⟩ at {frequency} Hz",
            far_slow_down(*places),
            SPREAD,
            places,
        )
        what = (
            f"change of ln(height of the paths) beyond {FAR}⟨d⟩ less {SPREAD:.0%} of that of all, "
            f"{frequency} Hz"
        )
        checks += [slowed, above(what, far_height_change(*places), 0, places)]
    return checks


def far_slow_down(free: Place, blocked: Place) -> UFloat:
    """Return the share of the slow-down that lies in columns far from the obstacle.

    It is taken bed by bed. Without obstacle all columns are alike, so their mean counts.
    """
    first, second = common_beds((free, blocked))
    before = free.profile("column_velocity")[0][first].mean(axis=1)
    after, column = blocked.profile("column_velocity")
    width = blocked["width"] * blocked["diameter"]
    far = np.abs(column - 0.5 * width) > FAR * blocked["diameter"]
    beyond, overall = after[second][:, far].mean(axis=1), after[second].mean(axis=1)
    return joined(far.mean() * (before - beyond) / (before - overall))


def far_height_change(free: Place, blocked: Place) -> UFloat:
    """Return by how much the logarithm of the far paths' height changes beyond `SPREAD`.

    That is, beyond this share of the change for all beads, whose sign counts as positive.
    """
    first, second = common_beds((free, blocked))
    everywhere, beyond = (
        np.log(blocked.values(name)[second] / free.values(name)[first])
        for name in ("path_vertical", "path_vertical_far")
    )
    return joined(np.sign(everywhere.mean()) * (beyond - SPREAD * everywhere))
