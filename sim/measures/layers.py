"""Surface, shear layer and plug of a flow, from profiles over height.

Profiles are arrays (H,) over slices of equal height, heights and diameters in m. Slices are thinner
than a sphere, so neighboring slices within one layer of spheres have the same velocity.
"""

from collections.abc import Mapping
from itertools import pairwise
from math import nan, sqrt
from typing import Any

import numpy as np

from sim.parameters.observables import declare_observables, observable
from sim.parameters.variables import ALL, HISTORY

#: Share of the mass below the surface; the rest are a few flying spheres.
SURFACE_SHARE = 0.99

#: The shear layer ends at this share of the velocity of the surface.
SHEAR_SHARE = 0.9

#: A plug shears less than this, over any diameter in it, relative to the flow below it.
PLUG_SHEAR = 0.05

#: Smallest share of the depth that a plug takes.
MIN_PLUG_SHARE = 0.3


def has_profiles(run: Mapping[Any, Any]) -> bool:
    """Return whether a replicate has profiles of a flow."""
    return "packing_profile" in run and bool(np.nansum(np.asarray(run["packing_profile"])) > 0)


def level(height: np.ndarray, density: np.ndarray, share: float) -> float:
    """Return the height (m) below which a share of the total of a density lies."""
    edges = np.append(height, 2 * height[-1] - height[-2]) - 0.5 * (height[1] - height[0])
    return float(np.interp(share, np.append(0, np.cumsum(density)) / density.sum(), edges))


def surface(height: np.ndarray, packing: np.ndarray) -> float:
    """Return the height (m) below which 99 % of the mass lies."""
    return level(height, packing, SURFACE_SHARE)


def mean_between(
    height: np.ndarray, values: np.ndarray, packing: np.ndarray, low: float, high: float
) -> float:
    """Return the mean of a profile over the mass between two heights, NaN where there is none."""
    inside = (height > low) & (height < high) & (packing > 0)
    return float(np.average(values[inside], weights=packing[inside])) if inside.any() else np.nan


def shear_depth(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return δ_s (m), the lowest height at which the velocity is 90 % of the surface's.

    That is the mean velocity of the mass within a diameter below the surface.
    """
    top = surface(height, packing)
    threshold = SHEAR_SHARE * mean_between(height, velocity, packing, top - diameter, top)
    fast = np.flatnonzero(velocity >= threshold)
    if not fast.size or not threshold > 0:
        return np.nan
    last = fast[0]
    if last == 0:
        return float(height[0])
    rise = velocity[last] - velocity[last - 1]
    share = (threshold - velocity[last - 1]) / rise if np.isfinite(rise) else 1.0
    return float(height[last - 1] + share * (height[last] - height[last - 1]))


def relative_shear(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return heights (P,) in m, and for each the shear above it over the shear below it.

    The shear below is the mean du/dz from the lowest centres to this height. The shear above is the
    larger of two: the mean du/dz up to the surface, and the largest over any diameter there. So a
    bulge of the velocity counts as shear, although its sides cancel in the mean.
    """
    top, bottom = surface(height, packing), 0.5 * diameter
    levels = height[(height > bottom) & (height < top - diameter) & np.isfinite(velocity)]
    is_known = np.isfinite(velocity)

    def velocity_at(level: Any) -> Any:
        return np.interp(level, height[is_known], velocity[is_known])

    below = (velocity_at(levels) - velocity_at(bottom)) / (levels - bottom)
    mean = np.abs(velocity_at(top) - velocity_at(levels)) / (top - levels)
    local = np.abs(velocity_at(levels + diameter) - velocity_at(levels)) / diameter
    # The largest shear over any diameter from a height on.
    local = np.maximum.accumulate(local[::-1])[::-1]
    shear = np.full(levels.size, np.inf)
    np.divide(np.maximum(mean, local), below, out=shear, where=below > 0)
    return levels, shear


def plug_base(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the lowest height (m) above which the flow shears less than 5 % of the shear below.

    A plug is at least a diameter thick. Without a plug this returns the surface.
    """
    levels, shear = relative_shear(height, velocity, packing, diameter)
    is_rigid = shear < PLUG_SHEAR
    return float(levels[is_rigid][0]) if is_rigid.any() else surface(height, packing)


def plug_share(
    height: np.ndarray, velocity: np.ndarray, packing: np.ndarray, diameter: float
) -> float:
    """Return the share of the depth that is plug, 0 without a plug."""
    top = surface(height, packing)
    return 1.0 - plug_base(height, velocity, packing, diameter) / top


def packing_by_diameters(
    height: np.ndarray, packing: np.ndarray, diameter: float, layers: int = 1
) -> np.ndarray:
    """Return packing fractions of layers ``layers`` diameters thick, from below up to the surface.

    A layer that the surface cuts is left out.
    """
    thickness = layers * diameter
    # The margin keeps rounding from cutting a layer that just fits.
    edges = thickness * np.arange(int(surface(height, packing) / thickness + 1e-9) + 1)
    pairs = pairwise(edges)
    return np.array([packing[(height > low) & (height < high)].mean() for low, high in pairs])


@observable(
    "missing_energy",
    system=ALL,
    unit="1",
    meaning="share of the energy turned over, gains included, that is not found",
)
def missing_energy(run: Mapping[Any, Any]) -> float:
    """Return the share of the energy turned over that the ledger lacks, NaN without a ledger.

    A run file has the share relative to the dissipated energy, or to the net work of a belt. Flows
    that accelerate turn over more, most of all those that lose nothing: a rolling sphere. Here
    their gain of kinetic energy counts too, from the means over the window. Without
    ``frictional_power`` (belt) the residual is the share. It says nothing of a belt whose bed moves
    as a block, which takes up and gives back energy and loses next to none.
    """
    if "energy_residual" not in run:
        return nan
    lacking = abs(float(run["energy_residual"]))
    if "frictional_power" not in run:
        return lacking
    lost = float(run["frictional_power"]) + float(run["normal_power"])
    mass = float(run["particles"]) * float(run["mass"])
    gained = mass * float(run["velocity"]) * float(run["acceleration"])
    return lacking * (lost / (lost + gained) if gained > 0 else 1.0)


# States of a deep flow and their lifetimes: deep shear, an agitated plug, or a locked plug.
#
# A flow without a plug (`layers.plug_share`) shears deep. A plug is locked if its spheres stay in
# touch, and agitated if they do not.

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
    if not ("contact_number" in run and has_profiles(run)):
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
    share = [plug_share(height, *profiles, diameter) for profiles in parts]
    return ends, np.array(share) > MIN_PLUG_SHARE


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

    ``inside`` (P,) says whether the flow was in the state in each of successive spells, and
    ``length`` (P,) how long each was.
    """
    time = float(length[inside].sum())
    ended = int((inside[:-1] & ~inside[1:]).sum())
    return time / float(length.sum()), time, float(ended)
