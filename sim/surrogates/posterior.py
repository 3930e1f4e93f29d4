"""Which parameters measurements allow: their posterior, by emcee on a surrogate."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.surrogates.answers import EVEN
from sim.surrogates.likelihood import Calibration, Predicted, distances
from sim.surrogates.process import on_one_thread
from sim.surrogates.sample import scaled, unscaled

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

#: Share of the posterior that may lie where no regime flows that the surrogate's mean is of.
MOST_UNCOUNTED = 0.5

#: Part of a range that is its end, and how much denser than elsewhere a posterior gathers there.
_END, _GATHERED = 0.02, 4.0

#: Share of the prior's interval from which on data say nothing of a parameter.
UNINFORMED = 0.8

#: Correlation from which on a combination of two parameters is known better than each.
RIDGE = 0.8

#: Conditions that are looked at for the next experiment, about.
_CANDIDATES = 200

#: Probabilities of a 95 % interval and its middle.
INTERVAL = (0.025, 0.5, 0.975)


@dataclass(frozen=True)
class Check:
    """What draws of a posterior say of the measurements.

    ``repeated`` (n, m) are the measurements made again; ``probability`` is that of measurements as
    far from the model as these; ``regimes`` holds the probability of each regime, mean over the
    draws, at the measurement that is least sure of a regime that it allows, and ``uncounted`` the
    share of draws where one that it does not allow is likelier.
    """

    repeated: np.ndarray
    probability: float
    regimes: dict[str, float]
    uncounted: float


@on_one_thread
def calibrate(calibration: Calibration) -> dict[str, xr.Dataset]:
    """Return the posterior and what follows from it, as groups that ArviZ reads.

    1. Draw points of the prior, and start the walkers at likely ones.
    2. Let the chains grow until they are `LONG_ENOUGH`, or `MOST_STEPS` long.
    3. Repeat the measurements for each draw: where these all but always lie nearer to the model
       than those made, or no regime that they allow is likely, nothing fits.
    4. Otherwise tell the parameters, and which further measurement would narrow them most.

    ``posterior`` has parameters and `DISCREPANCY`, over chain and draw; ``posterior_predictive``
    measurements repeated, (chain, draw, measurement); ``observed_data`` and ``constant_data`` the
    measurements, their conditions and errors; ``predictions_constant_data`` conditions of a further
    measurement, with the share of the variance of the posterior that it would take away
    (``narrowing``). Attributes of ``observed_data`` say how it ended, see `attributes`. Where
    nothing fits there is no ``posterior``.
    """
    chain, length, autocorrelation = _sample(calibration)
    check = check_draws(calibration, chain.reshape(-1, chain.shape[-1]))
    about = attributes(calibration, check, length, autocorrelation)
    over, name = ("chain", "draw", "measurement"), calibration.observable
    repeated = check.repeated.reshape(*chain.shape[:-1], -1)
    constant = {**calibration.conditions, "error": calibration.errors}
    groups = {
        "posterior_predictive": xr.Dataset({name: (over, repeated)}),
        "observed_data": xr.Dataset({name: (over[2:], calibration.values)}, attrs=about),
        "constant_data": xr.Dataset({key: (over[2:], one) for key, one in constant.items()}),
    }
    if about["outcome"] == "no fit":
        return groups
    further = {"predictions_constant_data": _next_experiment(calibration, chain)}
    return {"posterior": _posterior(calibration, chain)} | groups | further


def attributes(
    calibration: Calibration, check: Check, length: int, autocorrelation: float
) -> dict[str, Any]:
    """Return what a calibration says of itself, the attributes of ``observed_data``.

    ``outcome`` is ``converged``, ``not converged`` or ``no fit``; ``steps`` and
    ``autocorrelation`` are the length of the chains and their longest time; ``probability``,
    ``uncounted``, ``regimes`` and their ``regime_shares`` are as `Check` has them, and
    ``uncounted_regime`` is the likeliest of those that the surrogate's mean is not of, or empty.
    `sim.surrogates.inquiries` adds ``far``, the share that has no run near it,
    ``surrogate_error``, relative to the mean size of the observable, ``surrogate_points``, of which
    its mean is, and ``points``, all that it has.
    """
    regimes, counted = check.regimes, calibration.predictor.mean_regimes
    others = [name for name in regimes if name not in counted]
    outcome = "converged" if length >= LONG_ENOUGH * autocorrelation else "not converged"
    if check.probability < LEAST_PROBABILITY or check.uncounted > MOST_UNCOUNTED:
        outcome = "no fit"
    return {
        "outcome": outcome,
        "probability": check.probability,
        "uncounted": check.uncounted,
        "uncounted_regime": max(others, key=regimes.__getitem__, default=""),
        "regimes": list(regimes),
        "regime_shares": list(regimes.values()),
        "steps": length,
        "autocorrelation": autocorrelation,
        "discrepancy_scale": calibration.usual_error if calibration.has_discrepancy else 0.0,
        "observable": calibration.observable,
        "parameters": list(calibration.names),
        "scales": list(calibration.scales),
        "low": calibration.bounds[:, 0],
        "high": calibration.bounds[:, 1],
    }


def _sample(calibration: Calibration) -> tuple[np.ndarray, int, float]:
    """Return draws (walker, draw, p + 1), the length of the chains and their autocorrelation time.

    Chains grow until they are `LONG_ENOUGH`, or `MOST_STEPS` long. A tenth is left out.
    """
    import emcee

    rng = np.random.default_rng(calibration.seed)
    dimensions = len(calibration.names) + calibration.has_discrepancy
    walkers = max(_LEAST_WALKERS, _WALKERS * dimensions)
    sampler = emcee.EnsembleSampler(
        walkers,
        dimensions,
        calibration.log_probability,
        vectorize=True,
        moves=[(emcee.moves.StretchMove(), 0.5), (emcee.moves.DEMove(), 0.5)],
    )
    state = np.random.RandomState(calibration.seed).get_state()
    start = emcee.State(_start(calibration, (walkers, dimensions), rng), random_state=state)
    length, autocorrelation = 0, np.inf
    while length < MOST_STEPS and length < LONG_ENOUGH * autocorrelation:
        start = sampler.run_mcmc(start, _STEPS)
        length += _STEPS
        times = emcee.autocorr.integrated_time(sampler.get_chain(discard=length // 10), tol=0)
        autocorrelation = float(np.max(times)) if np.isfinite(times).all() else np.inf
    chain = sampler.get_chain(discard=length // 10)
    step = max(1, len(chain) // _DRAWS)
    return chain[::step].swapaxes(0, 1), length, autocorrelation


def _start(
    calibration: Calibration, shape: tuple[int, int], rng: np.random.Generator
) -> np.ndarray:
    """Return where walkers start: points of the prior, drawn by their probability, shifted."""
    (walkers, dimensions), count = shape, len(calibration.names)
    prior = rng.random((_STARTS, count))
    draws = np.column_stack([prior, np.abs(rng.normal(size=_STARTS))])[:, :dimensions]
    log_probability = calibration.log_probability(draws)
    weights = np.exp(log_probability - log_probability.max())
    chosen = draws[rng.choice(_STARTS, walkers, p=weights / weights.sum())]
    shifted = np.abs(chosen + _SHIFT * rng.normal(size=chosen.shape))
    # A point beyond the upper end is mirrored there.
    shifted[:, :count] = 1 - np.abs(1 - shifted[:, :count])
    return shifted


def check_draws(calibration: Calibration, draws: np.ndarray) -> Check:
    """Return what draws say of the measurements.

    Measurements are repeated for each draw, with a discrepancy as the prior has it: what a
    discrepancy that grew with the misfit explains is not explained (posterior predictive check,
    Gelman, Meng and Stern 1996).
    """
    rng = np.random.default_rng(calibration.seed)
    repeated, farther, regimes, uncounted = [], [], [], []
    for part in calibration.parts(draws):
        predicted = calibration.predict(calibration.of_theta(part))
        variance = calibration.errors**2 + calibration.discrepancy(part) ** 2
        allowed = calibration.allowed(predicted.regimes)
        least, rows = allowed.argmin(axis=1), np.arange(len(part))
        regimes.append(predicted.regimes[:, rows, least])
        uncounted.append(allowed[rows, least] < EVEN)
        predicted = _settled(calibration, predicted, variance, rng)
        shared = predicted.shared
        shift = (shared @ rng.normal(size=(*shared.shape[::2], 1)))[..., 0]
        spread = np.sqrt(predicted.own + variance)
        repeated.append(predicted.mean + shift + spread * rng.normal(size=shift.shape))
        before = calibration.usual_error * np.abs(rng.normal(size=(len(part), 1)))
        own = calibration.errors**2 + predicted.own
        spread = np.sqrt(own + (before * calibration.has_discrepancy) ** 2)
        again = shift + spread * rng.normal(size=shift.shape)
        made = calibration.values - predicted.mean
        farther.append(distances(again, shared, own)[0] >= distances(made, shared, own)[0])
    shares = np.concatenate(regimes, axis=1).mean(axis=1).tolist()
    return Check(
        np.concatenate(repeated),
        float(np.concatenate(farther).mean()),
        dict(zip(calibration.predictor.regimes.names, shares, strict=True)),
        float(np.concatenate(uncounted).mean()),
    )


def _settled(
    calibration: Calibration, predicted: Predicted, variance: np.ndarray, rng: np.random.Generator
) -> Predicted:
    """Return predictions in which a bed that has come to rest, by its measurement, gives 0."""
    if not calibration.may_rest.any():
        return predicted
    surety, flowing, resting = calibration.alternatives(predicted, variance)
    with np.errstate(over="ignore"):
        chance = surety / (surety + (1 - surety) * np.exp(resting - flowing))
    flows = np.ones(predicted.mean.shape)
    flows[:, calibration.may_rest] = rng.random(chance.shape) < chance
    return replace(
        predicted,
        mean=predicted.mean * flows,
        shared=predicted.shared * flows[..., None],
        own=predicted.own * flows,
    )


def _posterior(calibration: Calibration, chain: np.ndarray) -> xr.Dataset:
    count = len(calibration.names)
    theta = scaled(chain[..., :count], calibration.bounds, calibration.scales)
    columns = {name: theta[..., k] for k, name in enumerate(calibration.names)}
    if calibration.has_discrepancy:
        columns[DISCREPANCY] = calibration.usual_error * chain[..., count]
    return xr.Dataset({name: (("chain", "draw"), one) for name, one in columns.items()})


def _next_experiment(calibration: Calibration, chain: np.ndarray) -> xr.Dataset:
    """Return conditions within the ranges of the data, and how much each would tell.

    A measurement of f there, with the usual error and the present discrepancy, takes
    Σ Cov(θₖ, f)² / (Var f + v) from the variance of the posterior, where f depends on θ linearly
    and v is the variance of the measurement. Each θₖ counts in units of its range.
    """
    draws = chain.reshape(-1, chain.shape[-1])
    draws = draws[:: max(1, len(draws) // 1000)]
    ends = [(one.min(), one.max()) for one in calibration.conditions.values()]
    varied = sum(low < high for low, high in ends)
    count = max(3, round(_CANDIDATES ** (1 / max(1, varied))))
    lines = [np.linspace(low, high, count if low < high else 1) for low, high in ends]
    grid = [one.ravel() for one in np.meshgrid(*lines, indexing="ij")]
    candidates = dict(zip(calibration.conditions, grid, strict=True))
    shares = calibration.of_theta(draws)
    x = calibration.points(shares, candidates)
    mean, error = calibration.predictor.predict(x.reshape(-1, x.shape[2]))
    mean, error = mean.reshape(x.shape[:2]), error.reshape(x.shape[:2])
    unknown = error**2 + calibration.discrepancy(draws) ** 2
    variance = calibration.usual_error**2 + unknown.mean(axis=0)
    shares = shares - shares.mean(axis=0)
    covariance = shares.T @ (mean - mean.mean(axis=0)) / len(draws)
    taken = (covariance**2 / (mean.var(axis=0) + variance)).sum(axis=0)
    narrowing = taken / max(shares.var(axis=0).sum(), np.finfo(float).tiny)
    columns = candidates | {"narrowing": narrowing if candidates else narrowing[:1]}
    return xr.Dataset({name: ("candidate", one) for name, one in columns.items()})


def at_ends(groups: Mapping[str, xr.Dataset]) -> list[str]:
    """Return the parameters whose probability gathers at an end of their range."""
    if "posterior" not in groups or "parameters" not in groups["observed_data"].attrs:
        return []
    names = []
    for name, (low, high, scale) in ranges(groups).items():
        shares = unscaled(groups["posterior"][name].values[..., None], [(low, high)], [scale])
        if max(np.mean(shares < _END), np.mean(shares > 1 - _END)) > _GATHERED * _END:
            names.append(name)
    return names


def ranges(groups: Mapping[str, xr.Dataset]) -> dict[str, tuple[float, float, str]]:
    """Return lowest and highest value of each parameter looked for, and its scale."""
    about = groups["observed_data"].attrs
    keys = ("parameters", "low", "high", "scales")
    names, *columns = (np.atleast_1d(about[key]).tolist() for key in keys)
    return dict(zip(names, zip(*columns, strict=True), strict=True))


def summarize(groups: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Return a row per parameter: ``median``, ``low`` and ``high`` of the 95 % interval.

    ``share`` is the length of this interval over that of the prior, in the scale of the parameter;
    ``informed`` is whether it is below `UNINFORMED`: else the data say nothing of the parameter.
    """
    rows = []
    for name, (low, high, scale) in ranges(groups).items():
        least, median, most = np.quantile(groups["posterior"][name], INTERVAL)
        ends = np.array([least, most, low, high], float)
        first, last, *prior = np.log(ends) if scale == "log" else ends
        share = (last - first) / ((INTERVAL[2] - INTERVAL[0]) * (prior[1] - prior[0]))
        rows.append((name, median, least, most, share, bool(share < UNINFORMED)))
    return pd.DataFrame(rows, columns=["parameter", "median", "low", "high", "share", "informed"])


def ridges(groups: Mapping[str, xr.Dataset]) -> list[tuple[str, str, float]]:
    """Return the pairs of parameters of which a combination is known better than each.

    The third number is the correlation of their ranks, of size `RIDGE` or more.
    """
    from scipy.stats import rankdata

    names = list(ranges(groups))
    ranks = {name: rankdata(groups["posterior"][name].to_numpy().ravel()) for name in names}
    pairs = ((a, b) for number, b in enumerate(names) for a in names[:number])
    found = [(a, b, float(np.corrcoef(ranks[b], ranks[a])[0, 1])) for a, b in pairs]
    return [pair for pair in found if abs(pair[2]) >= RIDGE]
