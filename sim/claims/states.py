"""States of a deep flow: whether each replicate rides as a plug on its shear layer.

Replicates of one point may be in different states for as long as they are watched; then means of
all say nothing, and shares of runs and means within a state do.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from scipy.stats import chi2
from uncertainties import UFloat

from sim.claims.checks import reported
from sim.claims.inference import share_above, share_of
from sim.claims.place import Place, joined, measured
from sim.claims.verdict import Check, Untestable
from sim.dataset.measures import layers, plug

PROFILES = ("velocity_profile", "packing_profile")


def plug_shares(place: Place) -> np.ndarray:
    """Return the share of the depth that is plug, (R,)."""
    return place.each(partial(layers.plug_share, diameter=place["diameter"]), *PROFILES)


def has_plug(place: Place) -> np.ndarray:
    """Return whether each replicate (R,) rides as a plug of more than 30 % of its depth."""
    return plug_shares(place) > layers.PLUG


def share_with(plugs: np.ndarray) -> UFloat:
    """Return the share of runs (R,) with a plug: the middle of its 95 % interval, and that."""
    low, high = share_of(int(plugs.sum()), plugs.size)
    return measured(0.5 * (low + high), 0.5 * (high - low))


def of_most(check: Check, place: Place, values: np.ndarray) -> Check:
    """Return a check of a mean as it is, or of most runs where these are in different states.

    The mean of a mixture is that of no state, and its interval is not Student's. Then it is tested
    whether more than half of the runs, whose ``values`` (R,) these are, lie between the thresholds.
    """
    plugs = has_plug(place)
    if plugs.all() or not plugs.any():
        return check
    inside = int(((values > check.low) & (values < check.high)).sum())
    what = f"share of runs, {plugs.sum()} of {plugs.size} with a plug, that hold: {check.what}"
    return share_above(what, inside, plugs.size, 0.5, [place])


def shares(what: str, places: Sequence[Place]) -> list[Check]:
    """Return what is reported of states: the share of plugs, and the mean V of each state."""
    plugs = np.concatenate([has_plug(place) for place in places])
    speeds = np.concatenate([place.values("velocity") for place in places])
    told = f"{what}: {plugs.sum()} of {plugs.size} runs have a plug; its share"
    checks = [reported(told, share_with(plugs), places)]
    for name, state in (("with", plugs), ("without", ~plugs)):
        if state.any():
            mean = f"{what}: V of the runs {name} a plug"
            checks.append(reported(mean, joined(speeds[state]), places, "m/s"))
    return [*checks, *_lifetimes(what, places)]


def _lifetimes(what: str, places: Sequence[Place]) -> list[Check]:
    """Return what is reported of each state in which a flow was seen: its share and its lifetime.

    Nothing of runs from before such states were told.
    """
    try:
        times, endings = (
            {
                state: np.concatenate([place.values(f"{state}_{name}") for place in places])
                for state in plug.STATES
            }
            for name in ("time", "endings")
        )
    except Untestable:
        return []
    window, checks = sum(times.values()), []
    for state, time in times.items():
        if np.nansum(time) > 0:
            share = (time / window)[np.isfinite(time)]
            checks.append(reported(f"{what}: share of the time {state}", joined(share), places))
            lived = float(np.nansum(time)), int(np.nansum(endings[state]))
            told, lifetime = f"{what}: lifetime of the state {state}", lifetime_of(*lived)
            if not lived[1]:
                told += ", which never ended: longer than"
            checks.append(reported(told, lifetime, places, "s"))
    return checks


def lifetime_of(time: float, endings: int) -> UFloat | float:
    """Return the lifetime of a state that ends at random, from the time in it over all runs.

    With its 95 % interval, that of a rate of so many events: as far to both sides as to the farther
    one. Where it was never seen to end, what the lifetime exceeds with 95 % confidence.
    """
    if not endings:
        return 2.0 * time / float(chi2.ppf(0.95, 2))
    longest = 2.0 * time / float(chi2.ppf(0.025, 2 * endings))
    return measured(time / endings, longest - time / endings)
