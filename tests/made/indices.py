"""Made-up runs of designs for sensitivities: known functions of the unit cube, with known noise."""

from collections.abc import Callable

import numpy as np

from sim.study.design import block_size, unit_points
from sim.surrogates.indices import DesignRuns

Function = Callable[[np.ndarray], np.ndarray]


def made_runs(
    function: Function,
    kind: str,
    blocks: int,
    dimensions: int = 3,
    seed: int = 1,
    noise: float = 0.0,
    replicates: int = 2,
    places: Callable[[np.ndarray], np.ndarray] = lambda shares: shares,
) -> tuple[DesignRuns, np.ndarray, np.ndarray]:
    """Return runs of a design, the shares that it asks for and the places that it runs, (n, k).

    ``noise`` is the standard deviation of each replicate, relative to its value.
    """
    size = blocks * block_size(kind, dimensions)
    names = tuple("xyzuvwst"[:dimensions])
    shares = next(unit_points(kind, dimensions, size, seed))[:size]
    run = places(shares)
    points, number = np.unique(run, axis=0, return_inverse=True)
    values = function(points)[:, None] * np.ones(replicates)
    values *= 1 + noise * np.random.default_rng(seed).normal(size=values.shape)
    variances = values.var(axis=1, ddof=1) / replicates if replicates > 1 else np.nan * values[:, 0]
    means, number = values.mean(axis=1), number.ravel()
    return DesignRuns(names, means[number], variances[number], number), shares, run
