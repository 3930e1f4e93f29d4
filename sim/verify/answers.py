"""Known answers of the statistics: indices, surrogates and a posterior, with their coverage."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.stats import qmc

from sim.base.statistics import MANY, student
from sim.study.design import block_size, unit_points
from sim.surrogates.fit import fit_process
from sim.surrogates.indices import DesignRuns, sobol_indices_of_runs
from sim.surrogates.likelihood import Calibration
from sim.surrogates.posterior import calibrate, summarize
from sim.verify import exact
from sim.verify.rows import Found

Function = Callable[[np.ndarray], np.ndarray]

#: Blocks of a Saltelli design; designs whose intervals are counted, of indices and of posteriors.
BLOCKS, SEEDS, POSTERIORS = 256, 30, 8

#: Points of a surrogate, designs of it, and places at which it is compared.
POINTS, DESIGNS, PLACES = 64, 4, 2000


def indices(function: Function, seed: int) -> Any:
    """Return the table of first-order and total indices of a function of three parameters."""
    size = BLOCKS * block_size("saltelli", 3)
    shares = next(unit_points("saltelli", 3, size, seed))[:size]
    runs = DesignRuns(tuple("xyz"), function(shares), np.full(size, np.nan), np.arange(size))
    return sobol_indices_of_runs(runs).iloc[:6]


def held_indices(function: Function, truth: np.ndarray) -> float:
    """Return the share of intervals of indices that hold the truth, over designs."""
    tables = [indices(function, seed) for seed in range(1, SEEDS + 1)]
    return float(np.mean([(t.low <= truth) & (truth <= t.high) for t in tables]))


def of_surrogate(function: Function, dimensions: int, designs: int) -> tuple[float, float]:
    """Return Q² of surrogates, and the share of places whose interval holds, over designs."""
    found = []
    for seed in range(designs):
        x = qmc.Sobol(dimensions, rng=seed).random(POINTS)
        places = np.random.default_rng(1000 + seed).random((PLACES, dimensions))
        truth = function(places)
        mean, error = fit_process(x, function(x), np.zeros(POINTS), False).predict(places)
        quality = 1 - np.mean((mean - truth) ** 2) / truth.var()
        found.append((quality, np.mean(np.abs(mean - truth) <= student(MANY) * error)))
    quality, held = np.mean(found, axis=0)
    return float(quality), float(held)


#: A straight line as a surrogate without an error: what is looked for are offset and slope.
LINE: Any = SimpleNamespace(
    parameters=("offset", "slope", "place"),
    scales=("linear",) * 3,
    bounds=np.array([(-5.0, 5.0), (-5.0, 5.0), (0.0, 1.0)]),
    regimes=SimpleNamespace(names=("steady",)),
    mean_regimes=("steady",),
    predict=lambda x: (x[:, 0] + x[:, 1] * x[:, 2], np.zeros(len(x))),
    correlation=lambda x, others: (x[:, :, None] == others[:, None]).all(axis=-1).astype(float),
    probability=lambda x: np.ones((1, len(x))),
)


def posteriors() -> Found:
    """Posteriors of a line through five points with known errors, beside the Gaussian ones."""
    place, error = np.linspace(0, 1, 5), 0.1
    design = np.stack([np.ones(5), place], axis=1)
    covariance = error**2 * np.linalg.inv(design.T @ design)
    held, slopes = [], []
    for seed in range(POSTERIORS):
        rng = np.random.default_rng(seed)
        truth = rng.uniform(-2, 2, 2)
        values = design @ truth + error * rng.normal(size=5)
        groups = calibrate(
            Calibration(
                predictor=LINE,
                ranges={"offset": (-5.0, 5.0), "slope": (-5.0, 5.0)},
                conditions={"place": place},
                values=values,
                errors=np.full(5, error),
                observable="velocity",
                has_discrepancy=False,
            )
        )
        if "posterior" not in groups:
            held.append(0.0)
            continue
        rows = summarize(groups)
        held.append(np.mean((rows.low <= truth) & (truth <= rows.high)))
        mean = covariance[1] @ design.T @ values / error**2
        slopes.append((groups["posterior"]["slope"], mean))
    draws, mean = slopes[0]
    return {
        "posterior": (draws.mean(), mean),
        "spread": (draws.std(), covariance[1, 1] ** 0.5),
        "coverage": (np.mean(held), 0.95),
    }


def answers() -> Found:
    """Indices, surrogates and posteriors."""
    table, truth = indices(exact.ishigami, 1), exact.ISHIGAMI
    return {
        "first": (table["value"].iloc[0], truth[0]),
        "total": (table["value"].iloc[5], truth[5]),
        "indices": (held_indices(exact.ishigami, truth), 0.95),
        "kinks": (held_indices(exact.g_function, exact.g_indices(3).ravel()), 0.95),
        "ishigami": (of_surrogate(exact.ishigami, 3, DESIGNS)[1], 0.95),
        "borehole": (of_surrogate(exact.borehole, 8, 1)[0], 1.0),
        **posteriors(),
    }
