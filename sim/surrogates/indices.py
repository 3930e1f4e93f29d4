"""What matters, by a surrogate: Sobol' indices, by the estimators of SALib.

First-order index: the share of the variance that a parameter explains alone. Total index: its share
with all interactions. Both are of a parameter that is spread evenly over its range, in its scale.
Estimators: Saltelli et al. 2010, Comput. Phys. Commun. 181, 259; of interactions Saltelli 2002,
ibid. 145, 280.
"""

from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from sim.base.errors import percent
from sim.base.statistics import MANY, student
from sim.surrogates.caveats import EVEN
from sim.surrogates.fits import LENGTHS
from sim.surrogates.index_table import require_spread, shares_of, tabulate, with_doubts
from sim.surrogates.predictor import Predictor, counted_probability, scaled
from sim.surrogates.refusals import Refusal
from sim.surrogates.surrogate import Surrogate

#: Blocks of a sample of a surrogate, a power of two; and samples, with as many realisations each.
BLOCKS, _SCRAMBLINGS, _REALISATIONS = 2**11, 8, 4

#: Waves of a realisation, and its longest correlation length, of the unit cube.
_WAVES, _LONGEST = 128, 1.0

#: Share of the ranges without such a flow beyond which there are no indices, and the number of
#: points where this is looked at.
_MOST_ABSENT, _PLACES = 0.5, 2**12

#: Share of the variance that points do not tell of each other beyond which there are no indices.
_MOST_UNEXPLAINED = 0.5

_SEED = 1


def indices_of_surrogate(surrogate: Surrogate, source: str, blocks: int = BLOCKS) -> pd.DataFrame:
    """Return the indices of a surrogate as `sobol_indices`, with all that is weak about them.

    Parameters
    ----------
    surrogate : Surrogate
        The surrogate.
    source : str
        What the answer is called, for messages.
    blocks : int
        See `sobol_indices`.

    Raises
    ------
    Refusal
        If a flow of another regime is likelier in most of the ranges, or if it does not vary.
    """
    absent = _absent_share(surrogate)
    if absent > _MOST_ABSENT:
        raise Refusal(
            f"{source}: no indices, as surrogate {surrogate.name} is of flows that are "
            f"{' or '.join(surrogate.mean_regimes)}, and in {percent(absent)} of the ranges no "
            "such flow is likely, or no run is near; ask narrower ranges, or name other regimes "
            "with the surrogate"
        )
    if surrogate.unexplained > _MOST_UNEXPLAINED:
        raise Refusal(
            f"{source}: no indices, as the points of surrogate {surrogate.name} do not tell "
            f"{percent(min(1.0, surrogate.unexplained))} of the variance of each other; more "
            "points lessen it"
        )
    require_spread(surrogate.sample["mean"].values[surrogate.in_mean], source)
    table = sobol_indices(surrogate, blocks).assign(error=surrogate.error, absent=absent)
    return with_doubts(table)


def _absent_share(surrogate: Surrogate) -> float:
    """Return the share of the ranges where the mean means little.

    The regimes that it is of have less than half a chance there, or no run is near.
    """
    from scipy.stats import qmc

    shares = qmc.Sobol(len(surrogate.parameters), rng=_SEED).random(_PLACES)
    places = scaled(shares, surrogate.bounds, surrogate.scales)
    counted = counted_probability(surrogate, surrogate.probability(places))
    return float((surrogate.is_far(places) | (counted < EVEN)).mean())


def sobol_indices(predictor: Predictor, blocks: int = BLOCKS) -> pd.DataFrame:
    """Return first-order and total indices and interactions of a predictor, as a table.

    They are means over `_SCRAMBLINGS` independent samples of so many ``blocks``. The interval has
    two parts, added in quadrature. The sample's own is from the scatter between these. That of the
    surrogate is from realisations: its mean plus its error times a smooth random field of variance
    1, whose correlation length is drawn for each: from the shortest that a process may have.
    """
    from SALib.sample import sobol

    names, rng = list(predictor.parameters), np.random.default_rng(_SEED)
    # The unit cube, as SALib describes it.
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    estimates, deviations = [], []
    for seed in range(1, _SCRAMBLINGS + 1):
        shares = sobol.sample(problem, blocks, calc_second_order=True, seed=seed)
        mean, error = predictor.predict(scaled(shares, predictor.bounds, predictor.scales))
        estimates.append(_sobol(problem, mean))
        for _ in range(_REALISATIONS if error.any() else 0):
            values = mean + error * _smooth_field(shares, rng)
            deviations.append(_sobol(problem, values) - estimates[-1])
    sampling = student(_SCRAMBLINGS - 1) * np.std(estimates, axis=0, ddof=1) / np.sqrt(_SCRAMBLINGS)
    spread = np.sqrt(np.mean(np.square(deviations), axis=0)) if deviations else 0.0
    half = np.hypot(sampling, float(student(MANY)) * spread)
    middle = np.mean(estimates, axis=0)
    rows = [*shares_of(names), *(("interaction", *pair) for pair in combinations(names, 2))]
    return tabulate(rows, middle, middle - half, middle + half, blocks=_SCRAMBLINGS * blocks)


def _sobol(problem: dict[str, Any], values: np.ndarray) -> np.ndarray:
    """Return first-order and total indices, the sum of the former, and interactions."""
    from SALib.analyze import sobol

    analysis = sobol.analyze(problem, values, True, num_resamples=2, seed=_SEED)
    pairs = analysis["S2"][np.triu_indices(problem["num_vars"], 1)]
    return np.concatenate([analysis["S1"], analysis["ST"], [analysis["S1"].sum()], pairs])


def _smooth_field(shares: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a smooth random field of variance 1 at points (n, k) of the unit cube.

    It is a sum of waves of random direction and phase (Rahimi and Recht 2007), with a Gaussian
    correlation.
    """
    length = np.exp(rng.uniform(*np.log([LENGTHS[0], _LONGEST])))
    waves = rng.normal(size=(shares.shape[1], _WAVES)) / length
    phases = rng.uniform(0, 2 * np.pi, _WAVES)
    return np.sqrt(2 / _WAVES) * np.cos(shares @ waves + phases).sum(axis=1)
