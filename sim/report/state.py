"""How a study stands: what its points came to, and what to do about those that came to nothing."""

from collections.abc import Mapping, Sequence
from typing import Any

from sim.dataset.caveats import UNSOUND

#: Regimes that say that runs are too short to tell, or contradict each other.
OPEN = ("undetermined", "mixed")

#: The parameter that makes time steps shorter, by system.
SHORTER_STEPS = {
    "chute": "steps_per_collision",
    "belt": "steps_per_cycle",
    "conveyor": "steps_per_collision",
}


def state_of(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what the points of a study came to.

    Parameters
    ----------
    runs : sequence of mapping
        The table of runs, as `sim.report.runs.run_rows` returns it.

    Returns
    -------
    dict
        How many ``points`` there are, ``completed`` with at least one replicate, ``failed``,
        ``undetermined`` (or of replicates that contradict each other), and ``unsound``, whose
        energies do not add up; the ``worst`` of these, and the parameter that is the ``advice``.
        ``longer`` are the amounts that make runs of undetermined points longer, and ``drifting`` is
        how many of these points drift.
    """
    undetermined = [run for run in runs if run["regime"] in OPEN]
    unsound = [run for run in runs if run["missing_energy"] > UNSOUND]
    worst = max(unsound, key=lambda run: run["missing_energy"], default=None)
    failed = sum(run["regime"] == "failed" for run in runs)
    return {
        "points": len(runs),
        "completed": len(runs) - failed,
        "failed": failed,
        "undetermined": len(undetermined),
        "longer": sorted({_longer(run) for run in undetermined}),
        "drifting": sum(run["quality"] == "drifting" for run in undetermined),
        "unsound": len(unsound),
        "worst": worst,
        "advice": SHORTER_STEPS[worst["system"]] if worst else "",
    }


def _longer(run: Mapping[str, Any]) -> str:
    """Return the amount that makes the runs of a point longer; what has been run is kept."""
    if run["protocol"] == "published":
        return "average"
    return "limit" if "limit" in run["stopped"] else "target"
