"""Short points that share a process: its start costs more than they do."""

import hashlib
from collections.abc import Mapping

from sim.parameters import Parameters
from sim.study.cost import PROCESS_TIME, estimate

#: Seconds of computing that a batch should take, the least and the most. A point that takes more
#: than half of the most has a process of its own.
LEAST, MOST = 3.0, 60.0

#: Points of a batch at most: Snakemake looks through all of them for each.
CROWD = 50

#: Batches for each core, so that one that takes longer than estimated keeps none waiting for long.
PER_CORE = 2


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
    even = sum(seconds.values()) / (PER_CORE * cores) if cores else MOST
    share = min(max(even, LEAST), MOST)
    found: list[list[str]] = []
    full = 0.0
    for name in sorted(seconds, key=lambda name: (-seconds[name], name)):
        if not found or full + seconds[name] > share or len(found[-1]) == CROWD:
            found.append([])
            full = 0.0
        found[-1].append(name)
        full += seconds[name]
    return {_name(members): members for members in found if len(members) > 1}


def _name(members: list[str]) -> str:
    """Return a name that no other batch has."""
    return f"batch_{hashlib.sha256(' '.join(members).encode()).hexdigest()[:8]}"
