"""The state of a study: results of its points, and advice on undecided or unsound ones."""

from collections.abc import Mapping, Sequence
from typing import Any

from sim.dataset.caveats import UNSOUND_SHARE

#: Regimes of points whose runs are too short to decide, or contradict each other.
OPEN_REGIMES = ("undetermined", "mixed")

#: The parameter that makes time steps shorter, by system.
SHORTER_STEPS = {
    "chute": "steps_per_collision",
    "belt": "steps_per_cycle",
    "conveyor": "steps_per_collision",
}


def state_of(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return counts of the points of a study by result, and advice.

    Parameters
    ----------
    runs : sequence of mapping
        The table of runs, as `sim.report.runs.run_rows` returns it.

    Returns
    -------
    dict
        Numbers of ``points``: all, ``completed`` with at least one replicate, ``failed``,
        ``undetermined`` (or with replicates that contradict each other), and ``unsound``, whose
        energies do not add up. ``worst`` is the row of the worst unsound point, and ``advice`` the
        parameter that improves it. ``longer`` are the amounts that make runs of undetermined points
        longer, and ``drifting`` is the number of these points that drift.
    """
    undetermined = [run for run in runs if run["regime"] in OPEN_REGIMES]
    unsound = [run for run in runs if run["missing_energy"] > UNSOUND_SHARE]
    worst = max(unsound, key=lambda run: run["missing_energy"], default=None)
    failed = sum(run["regime"] == "failed" for run in runs)
    return {
        "points": len(runs),
        "completed": len(runs) - failed,
        "failed": failed,
        "undetermined": len(undetermined),
        "longer": sorted({_amount_to_raise(run) for run in undetermined}),
        "drifting": sum(run["quality"] == "drifting" for run in undetermined),
        "unsound": len(unsound),
        "worst": worst,
        "advice": SHORTER_STEPS[worst["system"]] if worst else "",
    }


def _amount_to_raise(run: Mapping[str, Any]) -> str:
    """Return the amount that makes the runs of a point longer, so that stored runs are kept."""
    if run["protocol"] == "published":
        return "average"
    return "limit" if "limit" in run["stopped"] else "target"
