"""States of a deep flow and their lifetimes: without a plug, with an agitated or a locked one.

A flow without a plug (`layers.plug_share`) shears deep; a plug is locked where its spheres stay in
touch, and agitated where they do not.
"""

from collections.abc import Mapping
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np

from sim.dataset.measures import layers
from sim.parameters.variables import HISTORY, PLUG_STATES

STATES = PLUG_STATES

#: Contacts per sphere from which a plug is locked: agitated ones have about 1, locked ones 2.7 or
#: more.
LOCKED = 2.0

#: Time (√(σ/g)) over which a state is told.
SPELL = 10.0


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return shares, times and endings of the states of a replicate over its averaging window.

    Whether there is a plug is told for each spell where the run has kept how its profiles change,
    else for the whole window. Nothing for a run without contact numbers, or of less than a spell.
    """
    if "contact_number" not in run:
        return {}
    ends, plug = _plugs(run)
    if not plug.size:
        return {}
    time, contacts = np.asarray(run["time"]), np.asarray(run["contact_number"])
    number = [contacts[(time > a) & (time <= b)].mean() for a, b in pairwise(ends)]
    state = np.where(plug, np.where(np.array(number) > LOCKED, 2, 1), 0)
    found: dict[str, float] = {}
    for index, name in enumerate(STATES):
        told = zip(("share", "time", "endings"), spells(state == index, np.diff(ends)), strict=True)
        found |= {f"{name}_{what}": value for what, value in told}
    return found


def _plugs(run: Mapping[Any, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends (P + 1,) of spells in s, from that of the one before on, and whether the flow
    had a plug in each (P,)."""
    diameter = float(run["diameter"])
    height, time = np.asarray(run["height"]), np.asarray(run["time"])
    start, least = float(run["average_start"]), SPELL * sqrt(diameter / float(run["gravity"]))
    names = ("velocity_profile", "packing_profile")
    if "block_end" in run:
        blocks = np.asarray(run["block_end"])
        velocity, packing = (np.asarray(run[name + HISTORY], float) for name in names)
        kept = np.isfinite(blocks)
        blocks, velocity, packing = blocks[kept], velocity[kept], packing[kept]
        ends = _spaced(np.concatenate([[start], blocks[blocks > start + 1e-9 * least]]), least)
        inside = [(blocks > a) & (blocks <= b) for a, b in pairwise(ends)]
        parts = [_mean(velocity[one], packing[one]) for one in inside]
    else:
        known = time[np.isfinite(np.asarray(run["contact_number"]))]
        ends = _spaced(np.concatenate([[start], known[known > start]]), least)
        velocity, packing = (np.asarray(run[name], float) for name in names)
        parts = [(velocity, packing)] * (len(ends) - 1)
    share = [layers.plug_share(height, *one, diameter) for one in parts]
    return ends, np.array(share) > layers.PLUG


def _spaced(ends: np.ndarray, least: float) -> np.ndarray:
    """Return those of some times (T,) that are ``least`` apart or more, the first among them."""
    chosen = [ends[0]]
    for end in ends[1:]:
        if end - chosen[-1] >= least * (1 - 1e-9):
            chosen.append(end)
    return np.array(chosen)


def _mean(velocity: np.ndarray, packing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean velocity, weighted by the packing, and the mean packing of blocks (B, H)."""
    moved, weight = (np.nan_to_num(velocity) * packing).sum(axis=0), packing.sum(axis=0)
    mean = np.divide(moved, weight, out=np.full_like(moved, np.nan), where=weight > 0)
    return mean, weight / len(packing)


def spells(inside: np.ndarray, length: np.ndarray) -> tuple[float, float, float]:
    """Return the share of the time in a state, that time, and how often it was seen to end.

    Parameters
    ----------
    inside : (P,) array
        Whether the flow was in the state in each of successive spells.
    length : (P,) array
        How long each lasted.
    """
    time = float(length[inside].sum())
    ended = int((inside[:-1] & ~inside[1:]).sum())
    return time / float(length.sum()), time, float(ended)
