"""States of a deep flow: whether each replicate rides as a plug on its shear layer.

Replicates of one point may stay in different states for the whole run. Then the mean over all of
them is meaningless; shares of runs and means within a state are not.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from scipy.stats import chi2
from uncertainties import UFloat

from sim.claims.checks import reported
from sim.claims.inference import share_above, share_interval
from sim.claims.place import Place, replicate_mean, with_interval
from sim.claims.verdict import Check, Untestable
from sim.measures import layers, plug

PROFILES = ("velocity_profile", "packing_profile")


def plug_shares(place: Place) -> np.ndarray:
    """Return the share of the depth taken by the plug, (R,)."""
    return place.measure_replicates(
        partial(layers.plug_share, diameter=place["diameter"]), *PROFILES
    )


def has_plug(place: Place) -> np.ndarray:
    """True per replicate (R,) that rides as a plug of more than 30 % of its depth."""
    return plug_shares(place) > layers.MIN_PLUG_SHARE


def plug_share(plugs: np.ndarray) -> UFloat:
    """Return the share of runs (R,) with a plug: middle and half width of its 95 % interval."""
    low, high = share_interval(int(plugs.sum()), plugs.size)
    return with_interval(0.5 * (low + high), 0.5 * (high - low))


def majority_if_mixed(check: Check, place: Place, values: np.ndarray) -> Check:
    """Return the check of a mean, or of a majority of runs where these are in different states.

    The mean of a mixture belongs to no state, and its interval is not Student's. The test is then
    whether more than half of the runs, with ``values`` (R,), lie between the thresholds.
    """
    plugs = has_plug(place)
    if plugs.all() or not plugs.any():
        return check
    inside = int(((values > check.low) & (values < check.high)).sum())
    quantity = f"share of runs, {plugs.sum()} of {plugs.size} with a plug, that hold: {check.what}"
    return share_above(quantity, inside, plugs.size, 0.5, [place])


def report_states(quantity: str, places: Sequence[Place]) -> list[Check]:
    """Report the states of flows: the share of runs with a plug, and the mean V of each state."""
    plugs = np.concatenate([has_plug(place) for place in places])
    speeds = np.concatenate([place.values("velocity") for place in places])
    label = f"{quantity}: {plugs.sum()} of {plugs.size} runs have a plug; its share"
    checks = [reported(label, plug_share(plugs), places)]
    for name, state in (("with", plugs), ("without", ~plugs)):
        if state.any():
            mean = f"{quantity}: V of the runs {name} a plug"
            checks.append(reported(mean, replicate_mean(speeds[state]), places, "m/s"))
    return [*checks, *_report_lifetimes(quantity, places)]


def _report_lifetimes(quantity: str, places: Sequence[Place]) -> list[Check]:
    """Report share of the time and lifetime of each state of a flow.

    Runs from before states were recorded have no such checks.
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
            checks.append(
                reported(f"{quantity}: share of the time {state}", replicate_mean(share), places)
            )
            time_and_endings = float(np.nansum(time)), int(np.nansum(endings[state]))
            label, lifetime = (
                f"{quantity}: lifetime of the state {state}",
                state_lifetime(*time_and_endings),
            )
            if not time_and_endings[1]:
                label += ", which never ended: longer than"
            checks.append(reported(label, lifetime, places, "s"))
    return checks


def state_lifetime(time: float, endings: int) -> UFloat | float:
    """Return the lifetime of a state that ends at random, from the time in it over all runs.

    Its 95 % interval is that of a rate of ``endings`` events, made symmetric by its farther end. A
    state that never ended has a lower bound of the lifetime instead, at 95 % confidence.
    """
    if not endings:
        return 2.0 * time / float(chi2.ppf(0.95, 2))
    longest = 2.0 * time / float(chi2.ppf(0.025, 2 * endings))
    return with_interval(time / endings, longest - time / endings)
