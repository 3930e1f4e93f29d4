"""Judges of Walton's claims about flows as a whole: velocity and depth, energy, forces."""

from dataclasses import replace
from functools import cache
from itertools import permutations
from math import inf, nan, radians, tan

import numpy as np
from scipy.stats import rankdata

from sim.base.statistics import student
from sim.claims.checks import above, below, within
from sim.claims.chute import base, driving, is_settled, repeated, speed, steady
from sim.claims.evidence import Evidence
from sim.claims.place import joined
from sim.claims.trends import pooled
from sim.claims.verdict import Check, Untestable
from sim.dataset.caveats import CLOSED

#: Largest number of values of which all orders are counted.
COUNTED = 9

#: Samples of the velocities from which the interval of a rank correlation is taken.
DRAWS = 4000

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
    """Rank correlation of V and n, its interval from velocities drawn within theirs.

    The threshold is the correlation that two-sided chance exceeds in one of twenty cases.
    """
    flows = {n: place for n, place in base(evidence, 1.24).items() if is_settled(place)}
    if len(flows) < 6 or max(flows) < 40:
        raise Untestable("fewer than six settled flows of depths from 1.24 to 40")
    speeds = [speed(place) for place in flows.values()]
    means, errors = zip(*((each.nominal_value, each.std_dev) for each in speeds), strict=True)
    drawn = np.random.default_rng(1).normal(means, errors, (DRAWS, len(speeds)))
    value, correlations = _rank_correlation(np.array([means])), _rank_correlation(drawn)
    half_width = np.abs(np.quantile(correlations, [0.025, 0.975]) - value).max()
    what = f"Spearman's ρ of V and n, {len(flows)} depths"
    check = above(what, float(value[0]), _chance(len(flows)), flows.values())
    return [replace(check, half_width=float(half_width))]


def _rank_correlation(rows: np.ndarray) -> np.ndarray:
    """Return Spearman's correlation of each row (D, N) of different values with its order."""
    number = rows.shape[1]
    apart = rankdata(rows, axis=1) - np.arange(1, number + 1)
    return 1 - 6 * (apart**2).sum(axis=1) / (number * (number**2 - 1))


@cache
def _chance(number: int) -> float:
    """Return a threshold above which a rank correlation of this many pairs has p < 0.05.

    Two-sided, of all orders where they can be counted.
    """
    if number > COUNTED:
        t = student(number - 2)
        return float(t / np.sqrt(number - 2 + t**2))
    found = _rank_correlation(np.array(list(permutations(range(number)))))
    values, times = np.unique(np.round(found, 9), return_counts=True)
    above_or_at = times[::-1].cumsum()[::-1] / len(found)
    return float(values[2 * above_or_at >= 0.05].max() + 1e-6)


def w24(evidence: Evidence) -> list[Check]:
    """Power lost by friction and by normal forces over that of the weight, and both shares."""
    flows = repeated(steady(evidence))
    if not flows:
        raise Untestable(f"no steady {evidence.protocol} flow of the base case with replicates")
    checks = []
    for n, place in flows.items():
        rubbed, struck = place.values("frictional_power"), place.values("normal_power")
        weight = place["particles"] * place["mass"] * driving(place)
        total = joined((rubbed + struck) / (weight * place.values("velocity")))
        share = joined(rubbed / (rubbed + struck))
        what = f"dissipated power over N m g V sin θ, n = {n:g}"
        checks.append(within(what, total, 1 - POWER, 1 + POWER, [place]))
        checks.append(within(f"share of friction in it, n = {n:g}", share, BOTH, 1 - BOTH, [place]))
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
