"""Observables of points: a number for each replicate, from scalars or from profiles."""

from collections.abc import Sequence

import numpy as np

from sim.dataset.results import Results
from sim.parameters.variables import OF_FAILURES
from sim.study.plottable import Observable


def replicate_values(
    results: Results, observable: Observable, points: Sequence[str]
) -> list[np.ndarray]:
    """Return one array per point: an observable of its replicates, in SI units.

    Replicates that failed, or have no finite value, are left out.
    """
    if observable.is_mean:
        values = [_means(results, point, observable.source) for point in points]
    elif observable.source in results.dataset:
        rows = results.dataset[[observable.source, "status"]].sel(point=list(points))
        is_shown = observable.source in OF_FAILURES or rows["status"] == "completed"
        values = list(rows[observable.source].where(is_shown).values)
    else:
        values = [np.zeros(0)] * len(points)
    return [row[np.isfinite(row)] for row in values]


def _means(results: Results, point: str, profile: str) -> np.ndarray:
    """Return the mean of a profile, weighted by packing, for each completed replicate, (R,).

    Not-a-number where no slice has a value.
    """
    values, _ = results.profile(point, profile)
    packing, _ = results.profile(point, "packing_profile")
    weight = np.where(np.isfinite(values), packing, 0.0)
    total = weight.sum(axis=1)
    sums = (np.nan_to_num(values) * weight).sum(axis=1)
    return np.divide(sums, total, out=np.full(len(total), np.nan), where=total > 0)
