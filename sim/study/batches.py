"""Short points that share a process: its start costs more than they do."""

import hashlib
from collections.abc import Mapping
from heapq import heappop, heappush
from math import ceil

from sim.parameters import Parameters
from sim.study.cost import PROCESS_TIME, estimate

#: Seconds of computing that a batch should take, the least and the most; between them each core has
#: one. A point that takes more than half of the most has a process of its own.
LEAST, MOST = 3.0, 60.0

#: Points of a batch at most: Snakemake looks through all of them for each.
CROWD = 50


def batches(points: Mapping[str, Parameters], cores: float | None) -> dict[str, list[str]]:
    """Return the batches of short points: names, and the ids of their points, longest first.

    Parameters
    ----------
    points : mapping
        Points that are to be run, by id. Those that take long or several threads, and one that
        would be alone, are in no batch.
    cores : float, optional
        On how many they run. Where nobody knows, as on a cluster, batches are as long as can be:
        there each is a job, which takes seconds to start.
    """
    seconds = {}
    for name, point in points.items():
        cost = estimate(point)
        if cost.threads == 1 and cost.core_seconds - PROCESS_TIME <= MOST / 2:
            seconds[name] = cost.core_seconds - PROCESS_TIME
    total = sum(seconds.values())
    share = min(max(total / cores, LEAST), MOST) if cores else MOST
    number = max(ceil(total / share), ceil(len(seconds) / CROWD))
    found: list[list[str]] = [[] for _ in range(number)]
    open_ = [(0.0, each) for each in range(number)]
    # The longest first, each to the batch that takes least: so all end at about the same time.
    for name in sorted(seconds, key=lambda name: (-seconds[name], name)):
        full, each = heappop(open_)
        found[each].append(name)
        if len(found[each]) < CROWD:
            heappush(open_, (full + seconds[name], each))
    return {_name(members): members for members in found if len(members) > 1}


def _name(members: list[str]) -> str:
    """Return a name that no other batch has."""
    return f"batch_{hashlib.sha256(' '.join(members).encode()).hexdigest()[:8]}"
