"""Observables of a run: numbers per replicate that its file does not hold, computed from it."""

from collections.abc import Mapping
from math import nan
from typing import Any

import numpy as np

from sim.base.additions import attribute_errors_to
from sim.dataset.run_file import Replicate, RunFile
from sim.parameters.variables import OBSERVABLE, Observable, observables


def measures(run: RunFile) -> dict[str, np.ndarray]:
    """Return the observables of a run, each an array over its replicates, NaN for failed ones."""
    declared, status = observables(run.attrs["system"]), run["status"]
    table = {name: np.full(len(status), nan) for name in declared}
    for index in np.flatnonzero(status == "completed"):
        replicate = Replicate(run, int(index))
        for name, value in measure(replicate, declared, run.attrs["point_id"]).items():
            table[name][index] = value
    return table


def measure(
    replicate: Mapping[str, Any], declared: Mapping[str, Observable], point: str
) -> dict[str, float]:
    """Return observables of a replicate; NaN where its file lacks the arrays for one.

    Each function is called once, however many observables it measures. ``point`` is the id of the
    point, for errors, which name the observable and its plug-in.
    """
    results: dict[int, Any] = {}
    values = {}
    for name, one in declared.items():
        with attribute_errors_to(OBSERVABLE, name, f" of {point}"):
            key = id(one.measure)
            if key not in results:
                results[key] = one.measure(replicate)
            result = results[key]
            values[name] = float(result.get(name, nan) if isinstance(result, Mapping) else result)
    return values
