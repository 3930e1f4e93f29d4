"""States of a deep flow and their lifetimes: deep shear, an agitated plug, or a locked plug.

A flow without a plug (`layers.plug_share`) shears deep. A plug is locked if its spheres stay in
touch, and agitated if they do not.
"""

from collections.abc import Mapping
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np

from sim.measures import layers
from sim.parameters.observables import declare_observables
from sim.parameters.variables import HISTORY

#: States of a deep flow, each with measures of its share, time and endings, in words.
STATES = {
    "deep_shear": "without a plug",
    "agitated": "with an agitated plug",
    "locked": "with a locked plug",
}

#: A plug with more contacts per sphere than this is locked. Agitated plugs have about 1, locked
#: plugs 2.7 or more.
LOCKED_CONTACTS = 2.0

#: Shortest time (√(σ/g)) over which a state is determined.
SPELL = 10.0


def plug_states(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return shares, times and endings of the states of a replicate over its averaging window.

    Each spell has or has not a plug, by its own profiles if the run has a history of profiles, and
    otherwise by those of the whole window. Empty for a run without contact numbers, or whose window
    is shorter than a spell.
    """
    if not ("contact_number" in run and layers.has_profiles(run)):
        return {}
    ends, plug = _plug_spells(run)
    if not plug.size:
        return {}
    time, contacts = np.asarray(run["time"]), np.asarray(run["contact_number"])
    number = [contacts[(time > a) & (time <= b)].mean() for a, b in pairwise(ends)]
    state = np.where(plug, np.where(np.array(number) > LOCKED_CONTACTS, 2, 1), 0)
    values: dict[str, float] = {}
    for index, name in enumerate(STATES):
        statistics = zip(
            ("share", "time", "endings"),
            spell_statistics(state == index, np.diff(ends)),
            strict=True,
        )
        values |= {f"{name}_{label}": value for label, value in statistics}
    return values


declare_observables(
    plug_states,
    {
        f"{state}_{ending}": (unit, f"{meaning} {phrase}")
        for ending, unit, meaning in (
            ("share", "1", "share of the window"),
            ("time", "s", "time of the window"),
            ("endings", "1", "how often the flow was seen to stop being"),
        )
        for state, phrase in STATES.items()
    },
    system="chute",
)


def _plug_spells(run: Mapping[Any, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounds (P + 1,) of spells in s, and whether the flow had a plug in each (P,)."""
    diameter = float(run["diameter"])
    height, time = np.asarray(run["height"]), np.asarray(run["time"])
    start, least = float(run["average_start"]), SPELL * sqrt(diameter / float(run["gravity"]))
    names = ("velocity_profile", "packing_profile")
    if "block_end" in run:
        blocks = np.asarray(run["block_end"])
        velocity, packing = (np.asarray(run[name + HISTORY], float) for name in names)
        is_used = np.isfinite(blocks)
        blocks, velocity, packing = blocks[is_used], velocity[is_used], packing[is_used]
        ends = _spaced_times(
            np.concatenate([[start], blocks[blocks > start + 1e-9 * least]]), least
        )
        inside = [(blocks > a) & (blocks <= b) for a, b in pairwise(ends)]
        parts = [_mean_profiles(velocity[mask], packing[mask]) for mask in inside]
    else:
        times = time[np.isfinite(np.asarray(run["contact_number"]))]
        ends = _spaced_times(np.concatenate([[start], times[times > start]]), least)
        velocity, packing = (np.asarray(run[name], float) for name in names)
        parts = [(velocity, packing)] * (len(ends) - 1)
    share = [layers.plug_share(height, *profiles, diameter) for profiles in parts]
    return ends, np.array(share) > layers.MIN_PLUG_SHARE


def _spaced_times(ends: np.ndarray, least: float) -> np.ndarray:
    """Return a selection of times (T,), from the first on, that are at least ``least`` apart."""
    selection = [ends[0]]
    for end in ends[1:]:
        if end - selection[-1] >= least * (1 - 1e-9):
            selection.append(end)
    return np.array(selection)


def _mean_profiles(velocity: np.ndarray, packing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean velocity, weighted by the packing, and the mean packing of blocks (B, H)."""
    moved, weight = (np.nan_to_num(velocity) * packing).sum(axis=0), packing.sum(axis=0)
    mean = np.divide(moved, weight, out=np.full_like(moved, np.nan), where=weight > 0)
    return mean, weight / len(packing)


def spell_statistics(inside: np.ndarray, length: np.ndarray) -> tuple[float, float, float]:
    """Return the share of the time in a state, that time, and the number of its endings.

    Parameters
    ----------
    inside : (P,) array
        Whether the flow was in the state in each of successive spells.
    length : (P,) array
        Duration of each spell.
    """
    time = float(length[inside].sum())
    ended = int((inside[:-1] & ~inside[1:]).sum())
    return time / float(length.sum()), time, float(ended)
