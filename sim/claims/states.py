"""States of a deep flow: whether each replicate rides as a plug on its shear layer.

Replicates of one point may be in different states for as long as they are watched; then means of
all say nothing, and shares of runs and means within a state do.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import reported
from sim.claims.inference import share_of
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
    checks = []
    for state in plug.STATES:
        try:
            share, lifetime = (
                np.concatenate([place.values(f"{state}_{name}") for place in places])
                for name in ("share", "lifetime")
            )
        except Untestable:
            continue
        if not np.nansum(share) > 0:
            continue
        told = f"{what}: share of the time {state}"
        checks.append(reported(told, joined(share[np.isfinite(share)]), places))
        lived = joined(lifetime[np.isfinite(lifetime)])
        checks.append(reported(f"{what}: lifetime of the state {state}", lived, places, "s"))
    return checks
