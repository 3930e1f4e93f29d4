"""States of a deep flow: whether each replicate rides as a plug on its shear layer.

Replicates of one point may stay in different states for the whole run. Then the mean over all of
them is meaningless; shares of runs and means within a state are not.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf, isfinite, nan

import numpy as np
from scipy.stats import chi2

from sim.claims.checks import reported
from sim.claims.inference import reported_share, share_above
from sim.claims.place import Place, replicate_mean
from sim.claims.verdict import Check, Untestable
from sim.measures import layers

PROFILES = ("velocity_profile", "packing_profile")


def plug_shares(place: Place) -> np.ndarray:
    """Return the share of the depth taken by the plug, (R,)."""
    return place.measure_replicates(
        partial(layers.plug_share, diameter=place["diameter"]), *PROFILES
    )


def has_plug(place: Place) -> np.ndarray:
    """True per replicate (R,) that rides as a plug of more than 30 % of its depth."""
    return plug_shares(place) > layers.MIN_PLUG_SHARE


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
    checks = [reported_share(f"{quantity}: runs with a plug", int(plugs.sum()), plugs.size, places)]
    for name, state in (("with", plugs), ("without", ~plugs)):
        if state.any():
            mean = f"{quantity}: V of the runs {name} a plug"
            check = reported(mean, replicate_mean(speeds[state]), places, "m/s")
            if state.sum() == 1:
                check = replace(check, half_width=nan, text=f"{check.value:.3g} (one run)")
            checks.append(check)
    return [*checks, *_report_lifetimes(quantity, places)]


def _report_lifetimes(quantity: str, places: Sequence[Place]) -> list[Check]:
    """Report share of the time and lifetime of each state of a flow.

    Runs from before states were recorded have no such checks.
    """
    try:
        times, endings = (
            {
                state: np.concatenate([place.values(f"{state}_{name}") for place in places])
                for state in layers.STATES
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
            label = f"{quantity}: lifetime of the state {state}"
            lifetime = state_lifetime(float(np.nansum(time)), int(np.nansum(endings[state])))
            checks.append(_report_lifetime(label, lifetime, places))
    return checks


def _report_lifetime(
    label: str, lifetime: tuple[float, float, float], places: Sequence[Place]
) -> Check:
    value, low, _ = lifetime
    ended = isfinite(value)
    value_text, low_text, high_text = (f"{float(f'{time:.3g}'):,g}" for time in lifetime)
    text = f"{value_text} ({low_text} to {high_text})" if ended else f"never ended, > {low_text}"
    check = reported(label, value if ended else low, places, "s")
    return replace(check, half_width=nan, text=text)


def state_lifetime(time: float, endings: int) -> tuple[float, float, float]:
    """Return the lifetime of a state that ends at random and its 95 % interval.

    ``time`` is that in the state over all runs. The interval is that of a rate of ``endings``
    events. A state that never ended has a lower bound alone, at 95 % confidence.
    """
    if not endings:
        return inf, 2.0 * time / float(chi2.ppf(0.95, 2)), inf
    low = 2.0 * time / float(chi2.ppf(0.975, 2 * endings + 2))
    return time / endings, low, 2.0 * time / float(chi2.ppf(0.025, 2 * endings))
