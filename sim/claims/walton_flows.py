"""Judges of Walton's claims about flows as a whole: velocity and depth, energy, forces."""

from dataclasses import replace
from math import inf, nan, radians, tan

import numpy as np

from sim.claims.checks import below, beside, reported, within
from sim.claims.chute import DEEPEST, WIDTHS, base, driving, repeated, steady, still_changing
from sim.claims.evidence import Evidence
from sim.claims.inference import trend
from sim.claims.place import Place, joined
from sim.claims.trends import pooled
from sim.claims.verdict import Check, Untestable
from sim.dataset.caveats import CLOSED

#: Depths over which the velocity tends to rise, and how many of them are enough.
RISING, ENOUGH = (1.24, 20), 6

#: Least share of the dissipated power that both kinds of losses must have.
BOTH = 0.05

#: Largest deviations of shear/normal from tan θ, of the normal force from N m g cos θ, and of the
#: dissipated power from N m g V sin θ.
RATIO, NORMAL, POWER = 0.005, 0.002, 0.02


def w5(evidence: Evidence) -> list[Check]:
    """The worst energy ledger of all replicates of all flows along any parameter of the paper.

    Points where a replicate has none leave the claim open.
    """
    lines = [base(evidence)]
    for along in ("friction", "restitution", "stiffness"):
        lines += [evidence.line("chute", along, depth=depth) for depth in lines[0]]
    places = {place.id: place for line in lines for place in line.values()}
    lacking = {key: place.values("missing_energy") for key, place in places.items()}
    known = {key: np.nanmax(values) for key, values in lacking.items() if np.isfinite(values).any()}
    if not known:
        raise Untestable(f"no {evidence.protocol} flow with a ledger")
    worst = max(known, key=known.__getitem__)
    what = f"largest share of the energy that a ledger lacks, {len(known)} points"
    checks = [below(what, known[worst], CLOSED, [places[worst]])]
    unknown = [places[key] for key, values in lacking.items() if not np.isfinite(values).all()]
    if unknown:
        what = f"share of the energy where a replicate has no ledger, {len(unknown)} points"
        checks.append(below(what, nan, CLOSED, unknown))
    # A ledger is exact bookkeeping: it needs no independent samples.
    return [replace(check, samples=inf) for check in checks]


def w9(evidence: Evidence) -> list[Check]:
    """Trend of V over the depths, within each width of the cell.

    The deepest flow counts with the lowest velocity that any window of it has: a bound, since it
    drifts.
    """
    strata: list[list[np.ndarray]] = []
    places: list[Place] = []
    depths: set[float] = set()
    for cell in WIDTHS:
        line = repeated(evidence.line("chute", "depth", cell=cell))
        flows = {n: place for n, place in line.items() if RISING[0] <= n <= RISING[1]}
        flows = {n: place for n, place in flows.items() if not still_changing(place)}
        groups = [place.values("velocity") for place in flows.values()]
        windows = evidence.line("chute", "transient", depth=DEEPEST, cell=cell)
        if windows:
            groups.append(np.array([min(one.values("velocity").min() for one in windows.values())]))
        if len(groups) > 1:
            strata.append(groups)
            places += flows.values()
            depths |= flows.keys()
    if len(depths) < ENOUGH or max(depths, default=0) < RISING[1]:
        raise Untestable("fewer than six depths from 1.24 to 20 whose flow does not accelerate")
    return [trend(f"V and n, {len(depths)} depths", strata, places)]


def w24(evidence: Evidence) -> list[Check]:
    """Share of friction in the losses of steady flows; their sum over N m g V sin θ is shown."""
    flows = repeated(steady(evidence))
    if not flows:
        raise Untestable(f"no steady {evidence.protocol} flow of the base case with replicates")
    checks = []
    for n, place in flows.items():
        rubbed, struck = place.values("frictional_power"), place.values("normal_power")
        weight = place["particles"] * place["mass"] * driving(place)
        total = joined((rubbed + struck) / (weight * place.values("velocity")))
        share, at = joined(rubbed / (rubbed + struck)), f"n = {n:g}"
        checks.append(
            within(f"share of friction in the losses, {at}", share, BOTH, 1 - BOTH, [place])
        )
        checks.append(reported(f"share of collisions in them, {at}", 1 - share, [place]))
        what = f"dissipated power over N m g V sin θ, {at}"
        checks += beside([within(what, total, 1 - POWER, 1 + POWER, [place])])
    return checks


def w26(evidence: Evidence) -> list[Check]:
    """Base forces of the steady flows against their weight, all together.

    A single flow is known to half a percent at best, so it counts where it is clearly off.
    """
    ratios, pressures, flows = [], [], steady(evidence)
    for place in flows.values():
        angle = radians(place["angle"])
        normal = place.value("base_normal", "base_normal_error")
        shear = place.value("base_shear", "base_shear_error")
        weight = place["particles"] * place["mass"] * place["gravity"]
        ratios.append(shear / normal / tan(angle) - 1)
        pressures.append(normal / (weight * np.cos(angle)) - 1)
    return [
        *pooled("shear/normal over tan θ, less 1", flows, ratios, -RATIO, RATIO),
        *pooled("normal over N m g cos θ, less 1", flows, pressures, -NORMAL, NORMAL),
    ]
