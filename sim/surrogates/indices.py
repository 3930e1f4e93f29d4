"""What matters: Sobol' indices and Morris' screening, by the estimators of SALib.

First-order index: the share of the variance that a parameter explains alone. Total index: its share
with all interactions. Both are of a parameter that is spread evenly over its range, in its scale.
Estimators: Saltelli et al. 2010, Comput. Phys. Commun. 181, 259; of interactions Saltelli 2002,
ibid. 145, 280. Morris' mean and deviation of elementary effects: Campolongo et al. 2007, Environ.
Model. Softw. 22, 1509.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from sim.base.statistics import MANY, student
from sim.study.sensitivity import FEWEST_BLOCKS
from sim.surrogates.predictor import Predictor, scaled
from sim.surrogates.refusals import Refusal

#: Columns of a table of indices: one value with its 95 % interval a row. ``other`` names the second
#: parameter of an interaction. ``blocks`` are those of the sample that count, ``left_out`` those
#: with a run that failed or has no value. ``noise`` is the share of the variance that the errors of
#: the runs explain, 0 for a surrogate.
COLUMNS = (
    *("index", "parameter", "other", "value", "low", "high"),
    *("blocks", "left_out", "noise"),
)

#: Blocks of a sample of a surrogate, a power of two; and samples, with as many realisations each.
BLOCKS, _SCRAMBLINGS, _REALISATIONS = 2**11, 8, 4

#: Resamples of the blocks of runs for an interval.
_RESAMPLES = 200

#: Waves of a realisation, and range of its correlation length, of the unit cube.
_WAVES, _LENGTHS = 128, (0.15, 1.0)

#: Levels of the design of Morris.
_LEVELS = 4

_SEED = 1


def sobol_indices(predictor: Predictor, blocks: int = BLOCKS) -> pd.DataFrame:
    """Return first-order and total indices and interactions of a surrogate, as `COLUMNS`.

    They are means over `_SCRAMBLINGS` independent samples of so many ``blocks``. The interval has
    two parts, added in quadrature. The sample's own is from the scatter between these. That of the
    surrogate is from realisations: its mean plus its error times a smooth random field of variance
    1, whose correlation length is drawn for each.
    """
    from SALib.sample import sobol

    problem, rng = _problem(predictor.parameters), np.random.default_rng(_SEED)
    estimates, deviations = [], []
    for seed in range(1, _SCRAMBLINGS + 1):
        shares = sobol.sample(problem, blocks, calc_second_order=True, seed=seed)
        mean, error = predictor.predict(scaled(shares, predictor.bounds, predictor.scales))
        estimates.append(_sobol(problem, mean, True)[0])
        for _ in range(_REALISATIONS if error.any() else 0):
            values = mean + error * _smooth_field(shares, rng)
            deviations.append(_sobol(problem, values, True)[0] - estimates[-1])
    sampling = student(_SCRAMBLINGS - 1) * np.std(estimates, axis=0, ddof=1) / np.sqrt(_SCRAMBLINGS)
    spread = np.sqrt(np.mean(np.square(deviations), axis=0)) if deviations else 0.0
    half = np.hypot(sampling, float(student(MANY)) * spread)
    total = _SCRAMBLINGS * blocks
    return _table(
        _sobol_names(problem["names"], True), np.mean(estimates, axis=0), half, total, 0, 0.0
    )


def sobol_indices_of_runs(
    names: Sequence[str], values: np.ndarray, errors: np.ndarray, source: str
) -> pd.DataFrame:
    """Return first-order and total indices from the runs of a Saltelli design, as `COLUMNS`.

    Parameters
    ----------
    names : sequence of str
        The k parameters.
    values, errors : numpy.ndarray
        Means of the runs and their standard errors (n,), in the order of the design: blocks of
        k + 2. Not-a-number stands for a run that failed, or whose flow has no value. The whole
        block of such a run is left out, as an estimator needs all of it.
    source : str
        What the answer is called, for messages.

    Raises
    ------
    Refusal
        If fewer than `FEWEST_BLOCKS` blocks are whole.
    """
    problem = _problem(names)
    rows, left_out = _whole_blocks(values, len(names) + 2, source)
    noise = _noise(values[rows].ravel(), errors[rows].ravel())
    estimate, sampling = _sobol(problem, values[rows].ravel(), False, _RESAMPLES)
    half = float(student(MANY)) * sampling
    labels = _sobol_names(problem["names"], False)
    return _table(labels, estimate, half, len(rows), left_out, noise)


def morris_indices_of_runs(
    names: Sequence[str], shares: np.ndarray, values: np.ndarray, errors: np.ndarray, source: str
) -> pd.DataFrame:
    """Return Morris' ``mu``, ``mu_star`` and ``sigma`` from the runs of a design, as `COLUMNS`.

    They are in the unit of the observable: its change where a parameter goes from the one end of
    its range to the other. Intervals are from resampled trajectories.

    Parameters
    ----------
    names, values, errors, source
        As for `sobol_indices_of_runs`; blocks are trajectories of k + 1 runs.
    shares : numpy.ndarray
        The points in the unit cube, (n, k).

    Raises
    ------
    Refusal
        If fewer than `FEWEST_BLOCKS` trajectories are whole.
    """
    problem = _problem(names)
    rows, left_out = _whole_blocks(values, len(names) + 1, source)
    estimate = _morris(problem, shares, values, rows)
    rng = np.random.default_rng(_SEED)
    resampled = [
        _morris(problem, shares, values, rows[rng.integers(len(rows), size=len(rows))])
        for _ in range(_RESAMPLES)
    ]
    half = float(student(MANY)) * np.std(resampled, axis=0, ddof=1)
    labels = [(index, name, "") for index in ("mu", "mu_star", "sigma") for name in names]
    noise = _noise(values[rows].ravel(), errors[rows].ravel())
    return _table(labels, estimate, half, len(rows), left_out, noise)


def _problem(names: Sequence[str]) -> dict[str, Any]:
    """Return the unit cube as SALib describes it."""
    return {"num_vars": len(names), "names": list(names), "bounds": [[0.0, 1.0]] * len(names)}


def _sobol(
    problem: dict[str, Any], values: np.ndarray, second: bool, resamples: int = 2
) -> tuple[np.ndarray, np.ndarray]:
    """Return indices in the order of `_sobol_names`, and their standard errors from the sample.

    All are not-a-number where the values do not vary.
    """
    from SALib.analyze import sobol

    number = len(_sobol_names(problem["names"], second))
    if np.ptp(values) <= np.finfo(float).eps * np.abs(values).max():
        return np.full(number, np.nan), np.full(number, np.nan)
    analysis = sobol.analyze(problem, values, second, num_resamples=resamples, seed=_SEED)
    pairs = np.triu_indices(problem["num_vars"], 1)
    keys = ("S1", "ST", *(["S2"] if second else []))
    parts = [(analysis[key], analysis[f"{key}_conf"]) for key in keys]
    parts[2:] = [(value[pairs], half[pairs]) for value, half in parts[2:]]
    estimate, half = (np.concatenate(part) for part in zip(*parts, strict=True))
    return estimate, half / float(student(MANY))


def _sobol_names(names: Sequence[str], second: bool) -> list[tuple[str, str, str]]:
    """Return index, parameter and other parameter of each value."""
    pairs = [("interaction", one, other) for k, one in enumerate(names) for other in names[k + 1 :]]
    alone = [(index, name, "") for index in ("first", "total") for name in names]
    return alone + (pairs if second else [])


def _morris(
    problem: dict[str, Any], shares: np.ndarray, values: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """Return ``mu``, ``mu_star`` and ``sigma`` of all parameters, from some trajectories."""
    from SALib.analyze import morris

    chosen = rows.ravel()
    analysis = morris.analyze(
        problem, shares[chosen], values[chosen], num_resamples=2, num_levels=_LEVELS, seed=_SEED
    )
    return np.concatenate([np.asarray(analysis[key], float) for key in ("mu", "mu_star", "sigma")])


def _whole_blocks(values: np.ndarray, size: int, source: str) -> tuple[np.ndarray, int]:
    """Return the rows of each block without a missing value (b, size), and how many have one."""
    rows = np.arange(len(values) // size * size).reshape(-1, size)
    whole = rows[np.isfinite(values[rows]).all(axis=1)]
    if len(whole) < FEWEST_BLOCKS:
        raise Refusal(
            f"{source}: no indices, as {len(whole)} of {len(rows)} blocks of {size} points have a "
            f"value at each and {FEWEST_BLOCKS} are needed; more blocks, other ranges or the key "
            "regimes may give others"
        )
    return whole, len(rows) - len(whole)


def _noise(values: np.ndarray, errors: np.ndarray) -> float:
    """Return the share of the variance of values that their errors explain."""
    variance = values.var()
    return float(np.nanmean(errors**2) / variance) if variance > 0 else 0.0


def _smooth_field(shares: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a smooth random field of variance 1 at points (n, k) of the unit cube.

    It is a sum of waves of random direction and phase (Rahimi and Recht 2007), with a Gaussian
    correlation.
    """
    length = np.exp(rng.uniform(*np.log(_LENGTHS)))
    waves = rng.normal(size=(shares.shape[1], _WAVES)) / length
    phases = rng.uniform(0, 2 * np.pi, _WAVES)
    return np.sqrt(2 / _WAVES) * np.cos(shares @ waves + phases).sum(axis=1)


def _table(
    names: Sequence[tuple[str, str, str]],
    estimate: np.ndarray,
    half: np.ndarray,
    blocks: int,
    left_out: int,
    noise: float,
) -> pd.DataFrame:
    """Return values with intervals as a table of `COLUMNS`."""
    rows = [
        (*name, value, value - width, value + width, blocks, left_out, noise)
        for name, value, width in zip(names, estimate, half, strict=True)
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))
