"""Which parameters measurements allow: their posterior, by emcee on a surrogate.

Measurement i under conditions cᵢ is normal about the surrogate's mean m(θ, cᵢ) with the variance
eᵢ² + s(θ, cᵢ)² + d²: error of the measurement, error of the surrogate, and what the model may lack.
θ is uniform over its ranges, in the scale of the surrogate; d has a half-normal prior whose
scale is the median error (Kennedy and O'Hagan 2001, J. R. Stat. Soc. B 63, 425, with a discrepancy
that differs from one measurement to the next without correlation).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.surrogates.predictor import Predictor, scaled

#: Name of the size of the discrepancy among the parameters of a posterior.
DISCREPANCY = "discrepancy"

#: Autocorrelation times that a chain must be long, as emcee's guide advises; and most steps.
LONG_ENOUGH, MOST_STEPS = 50, 40_000

#: Steps after which chains are looked at, walkers for each parameter, and at least.
_STEPS, _WALKERS, _LEAST_WALKERS = 1000, 8, 24

#: Points of the prior from which the walkers start, and their shift, of the unit cube.
_STARTS, _SHIFT = 4000, 0.01

#: Draws that are kept at most of each walker.
_DRAWS = 200

#: Probability of measurements as far from the model as these, below which nothing fits.
LEAST_PROBABILITY = 0.01

#: Share of the prior's interval from which on data say nothing of a parameter.
UNINFORMED = 0.8

#: Conditions that are looked at for the next experiment, about.
_CANDIDATES = 200

#: Probabilities of a 95 % interval and its middle.
INTERVAL = (0.025, 0.5, 0.975)


@dataclass(frozen=True)
class Calibration:
    """Measurements, and the surrogate whose parameters they are to tell.

    Attributes
    ----------
    predictor : Predictor
        The surrogate.
    ranges : mapping
        Lowest and highest value of each parameter looked for.
    conditions : mapping
        Values of all other parameters of the surrogate at each measurement, (m,).
    values, errors : numpy.ndarray
        The measurements and their standard errors (m,), in the unit of the surrogate.
    observable : str
        What was measured.
    seed : int
        Seed of the walkers.
    """

    predictor: Predictor
    ranges: Mapping[str, tuple[float, float]]
    conditions: Mapping[str, np.ndarray]
    values: np.ndarray
    errors: np.ndarray
    observable: str
    seed: int = 1

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The parameters looked for, in the order of the surrogate."""
        return tuple(name for name in self.predictor.parameters if name in self.ranges)

    @property
    def bounds(self) -> np.ndarray:
        """Ranges of these parameters, (p, 2)."""
        return np.array([self.ranges[name] for name in self.names], float)

    @property
    def scales(self) -> tuple[Any, ...]:
        """Scales of these parameters."""
        by_name = dict(zip(self.predictor.parameters, self.predictor.scales, strict=True))
        return tuple(by_name[name] for name in self.names)

    @property
    def usual_error(self) -> float:
        """Median error of the measurements, the scale of the discrepancy."""
        return float(np.median(self.errors))

    def predict(
        self, shares: np.ndarray, conditions: Mapping[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return means and errors (n, m) at n points of the unit cube of θ and m conditions."""
        theta = dict(zip(self.names, scaled(shares, self.bounds, self.scales).T, strict=True))
        count = len(next(iter(conditions.values()))) if conditions else 1
        shape = (len(shares), count)
        columns = [
            np.broadcast_to(theta[name][:, None] if name in theta else conditions[name], shape)
            for name in self.predictor.parameters
        ]
        mean, error = self.predictor.predict(np.stack(columns, axis=-1).reshape(-1, len(columns)))
        return self._per_measurement(mean.reshape(shape)), self._per_measurement(
            error.reshape(shape)
        )

    def _per_measurement(self, table: np.ndarray) -> np.ndarray:
        """Return one column per measurement where there are no conditions."""
        return table if self.conditions else np.repeat(table, len(self.values), axis=1)

    def log_probability(self, draws: np.ndarray) -> np.ndarray:
        """Return the logarithm of posterior density (n,), up to a constant.

        ``draws`` (n, p + 1) are θ in the unit cube, and d over `usual_error`.
        """
        shares, size = draws[:, :-1], draws[:, -1]
        inside = ((shares >= 0) & (shares <= 1)).all(axis=1) & (size >= 0)
        densities = np.full(len(draws), -np.inf)
        if inside.any():
            mean, error = self.predict(shares[inside], self.conditions)
            discrepancy = self.usual_error * size[inside, None]
            variance = self.errors**2 + error**2 + discrepancy**2
            terms = (self.values - mean) ** 2 / variance + np.log(variance)
            densities[inside] = -0.5 * (terms.sum(axis=1) + size[inside] ** 2)
        return densities


def calibrate(calibration: Calibration) -> dict[str, xr.Dataset]:
    """Return the posterior and what follows from it, as groups that ArviZ reads.

    Returns
    -------
    dict of xarray.Dataset
        ``posterior``: parameters and `DISCREPANCY`, over chain and draw. ``posterior_predictive``:
        measurements repeated, (chain, draw, measurement). ``observed_data`` and ``constant_data``:
        the measurements, their conditions and errors. ``predictions_constant_data``: conditions of
        a further measurement, with the share of the variance of the posterior that it would take
        away (``narrowing``). Attributes of ``observed_data`` say how it ended: ``outcome`` is
        ``converged``, ``not converged`` or ``no fit``, ``probability`` that of measurements as far
        from the model as these, ``steps`` and ``autocorrelation`` the length of the chains and
        their longest time. Where nothing fits there is no ``posterior``.
    """
    chain, length, autocorrelation = _sample(calibration)
    probability = _probability(calibration, chain.reshape(-1, chain.shape[-1]))
    if probability < LEAST_PROBABILITY:
        outcome = "no fit"
    else:
        enough = length >= LONG_ENOUGH * autocorrelation
        outcome = "converged" if enough else "not converged"
    attributes = {
        "outcome": outcome,
        "probability": probability,
        "steps": length,
        "autocorrelation": autocorrelation,
        "discrepancy_scale": calibration.usual_error,
        "observable": calibration.observable,
        "parameters": list(calibration.names),
        "scales": list(calibration.scales),
        "low": calibration.bounds[:, 0],
        "high": calibration.bounds[:, 1],
    }
    over = ("chain", "draw")
    groups = {} if outcome == "no fit" else {"posterior": _posterior(calibration, chain)}
    groups["posterior_predictive"] = xr.Dataset(
        {calibration.observable: ((*over, "measurement"), _repeated(calibration, chain))}
    )
    groups["observed_data"] = xr.Dataset(
        {calibration.observable: ("measurement", calibration.values)}, attrs=attributes
    )
    conditions = {name: ("measurement", one) for name, one in calibration.conditions.items()}
    groups["constant_data"] = xr.Dataset(
        {**conditions, "error": ("measurement", calibration.errors)}
    )
    if outcome != "no fit":
        groups["predictions_constant_data"] = _next_experiment(calibration, chain)
    return groups


def _sample(calibration: Calibration) -> tuple[np.ndarray, int, float]:
    """Return draws (walker, draw, p + 1), the length of the chains and their autocorrelation time.

    Chains grow until they are `LONG_ENOUGH`, or `MOST_STEPS` long. A tenth is left out.
    """
    import emcee

    rng = np.random.default_rng(calibration.seed)
    dimensions = len(calibration.names) + 1
    walkers = max(_LEAST_WALKERS, _WALKERS * dimensions)
    sampler = emcee.EnsembleSampler(
        walkers,
        dimensions,
        calibration.log_probability,
        vectorize=True,
        moves=[(emcee.moves.StretchMove(), 0.5), (emcee.moves.DEMove(), 0.5)],
    )
    state = np.random.RandomState(calibration.seed).get_state()
    start = emcee.State(_start(calibration, walkers, rng), random_state=state)
    length, autocorrelation = 0, np.inf
    while length < MOST_STEPS and length < LONG_ENOUGH * autocorrelation:
        start = sampler.run_mcmc(start, _STEPS)
        length += _STEPS
        times = emcee.autocorr.integrated_time(sampler.get_chain(discard=length // 10), tol=0)
        autocorrelation = float(np.max(times)) if np.isfinite(times).all() else np.inf
    chain = sampler.get_chain(discard=length // 10)
    step = max(1, len(chain) // _DRAWS)
    return chain[::step].swapaxes(0, 1), length, autocorrelation


def _start(calibration: Calibration, walkers: int, rng: np.random.Generator) -> np.ndarray:
    """Return where walkers start: points of the prior, drawn by their probability, shifted."""
    prior = rng.random((_STARTS, len(calibration.names)))
    draws = np.column_stack([prior, np.abs(rng.normal(size=_STARTS))])
    log_probability = calibration.log_probability(draws)
    weights = np.exp(log_probability - log_probability.max())
    chosen = draws[rng.choice(_STARTS, walkers, p=weights / weights.sum())]
    shifted = np.abs(chosen + _SHIFT * rng.normal(size=chosen.shape))
    # A point beyond the upper end is mirrored there.
    shifted[:, :-1] = 1 - np.abs(1 - shifted[:, :-1])
    return shifted


def _probability(calibration: Calibration, draws: np.ndarray) -> float:
    """Return how probable measurements are that lie as far from the model as those that were made.

    Measurements are repeated for each draw of the posterior, with a discrepancy as the prior has
    it: what a discrepancy that grew with the misfit explains is not explained (posterior predictive
    check, Gelman, Meng and Stern 1996).
    """
    rng = np.random.default_rng(calibration.seed)
    mean, error = calibration.predict(draws[:, :-1], calibration.conditions)
    variance = calibration.errors**2 + error**2
    discrepancy = calibration.usual_error * np.abs(rng.normal(size=(len(draws), 1)))
    repeated = rng.normal(size=mean.shape) * np.sqrt(variance + discrepancy**2)
    distance = ((calibration.values - mean) ** 2 / variance).sum(axis=1)
    return float(np.mean((repeated**2 / variance).sum(axis=1) >= distance))


def _posterior(calibration: Calibration, chain: np.ndarray) -> xr.Dataset:
    """Return the draws as parameters over chain and draw."""
    theta = scaled(chain[..., :-1], calibration.bounds, calibration.scales)
    columns = {name: theta[..., k] for k, name in enumerate(calibration.names)}
    columns[DISCREPANCY] = calibration.usual_error * chain[..., -1]
    return xr.Dataset({name: (("chain", "draw"), one) for name, one in columns.items()})


def _repeated(calibration: Calibration, chain: np.ndarray) -> np.ndarray:
    """Return measurements as they would come out again, for each draw."""
    rng = np.random.default_rng(calibration.seed)
    draws = chain.reshape(-1, chain.shape[-1])
    mean, error = calibration.predict(draws[:, :-1], calibration.conditions)
    discrepancy = calibration.usual_error * draws[:, -1:]
    spread = np.sqrt(calibration.errors**2 + error**2 + discrepancy**2)
    return (mean + spread * rng.normal(size=mean.shape)).reshape(*chain.shape[:-1], -1)


def _next_experiment(calibration: Calibration, chain: np.ndarray) -> xr.Dataset:
    """Return conditions within the ranges of the data, and how much each would tell.

    A measurement of f there, with the usual error and the present discrepancy, takes
    Σ Cov(θₖ, f)² / (Var f + v) from the variance of the posterior, where f depends on θ linearly
    and v is the variance of the measurement. Each θₖ counts in units of its range.
    """
    draws = chain.reshape(-1, chain.shape[-1])
    draws = draws[:: max(1, len(draws) // 1000)]
    axes = [np.unique([one.min(), one.max()]) for one in calibration.conditions.values()]
    varied = sum(len(one) > 1 for one in axes)
    count = max(3, round(_CANDIDATES ** (1 / max(1, varied))))
    lines = [np.linspace(one[0], one[-1], count if len(one) > 1 else 1) for one in axes]
    grid = [one.ravel() for one in np.meshgrid(*lines, indexing="ij")]
    candidates = dict(zip(calibration.conditions, grid, strict=True))
    mean, error = calibration.predict(draws[:, :-1], candidates)
    discrepancy = calibration.usual_error * draws[:, -1:]
    variance = calibration.usual_error**2 + (error**2 + discrepancy**2).mean(axis=0)
    shares = draws[:, :-1] - draws[:, :-1].mean(axis=0)
    covariance = shares.T @ (mean - mean.mean(axis=0)) / len(draws)
    taken = (covariance**2 / (mean.var(axis=0) + variance)).sum(axis=0)
    narrowing = taken / max(shares.var(axis=0).sum(), np.finfo(float).tiny)
    columns = candidates | {"narrowing": narrowing if candidates else narrowing[:1]}
    return xr.Dataset({name: ("candidate", one) for name, one in columns.items()})


def summarize(groups: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Return a row per parameter: ``median``, ``low`` and ``high`` of the 95 % interval.

    ``share`` is the length of this interval over that of the prior, in the scale of the parameter;
    ``informed`` is whether it is below `UNINFORMED`: else the data say nothing of the parameter.
    """
    attributes = groups["observed_data"].attrs
    rows = []
    for name, low, high, scale in zip(
        *(np.atleast_1d(attributes[key]) for key in ("parameters", "low", "high", "scales")),
        strict=True,
    ):
        least, median, most = np.quantile(groups["posterior"][name], INTERVAL)
        ends = np.array([least, most, low, high], float)
        first, last, *prior = np.log(ends) if scale == "log" else ends
        share = (last - first) / ((INTERVAL[2] - INTERVAL[0]) * (prior[1] - prior[0]))
        rows.append((name, median, least, most, share, bool(share < UNINFORMED)))
    return pd.DataFrame(rows, columns=["parameter", "median", "low", "high", "share", "informed"])
