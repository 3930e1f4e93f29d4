"""Points, series of their flows, and random series with known properties."""

import numpy as np
from scipy.signal import lfilter

from sim.engine.systems import build, replica
from sim.parameters import Parameters, parse_point


def chute_point(**values) -> Parameters:
    """Parameters of the chute, changed."""
    return parse_point({"system": "chute", **values}, "test")


def belt_point(**values) -> Parameters:
    """Parameters of the belt, changed."""
    return parse_point({"system": "belt", **values}, "test")


def sums_of(system) -> tuple:
    """What the profiles of the next sample add."""
    profiles = system.sample(1, profiles=True).profiles
    return tuple(type(several)(*(part[0] for part in several)) for several in profiles)


def series_of(parameters: Parameters, replicate: int = 0) -> dict[str, np.ndarray]:
    """Time series (T,) of one replicate, transient and average."""
    system = build(parameters, replicate)
    system.settle()
    total = parameters.transient_samples + parameters.average_samples
    samples = [system.advance() for _ in range(total)]
    return {name: np.array([sample[name] for sample in samples]) for name in system.series}


def energy_residual(series: dict[str, np.ndarray], ledger) -> float:
    """What a ledger lacks after the first sample, relative to the energy turned over."""
    total = sum(sign * series[name] for name, sign in ledger.terms.items())
    turnover = sum(series[name][-1] - series[name][0] for name in ledger.turnover)
    return float((total[-1] - total[0]) / turnover)


def pause_within_samples(monkeypatch, point: Parameters) -> None:
    """Let a state be offered three times in each sample, of which a run else takes several in one
    go."""
    monkeypatch.setattr(replica, "MOST_WORK", point.particles * point.sample_steps // 3 + 1)


def correlated(rng, samples: int, inefficiency: float) -> np.ndarray:
    """Noise of mean 0 and variance 1 whose neighbors are correlated (first-order autoregressive).

    ``inefficiency`` is (1 + φ)/(1 - φ), how many samples are worth one independent one.
    """
    memory = (inefficiency - 1.0) / (inefficiency + 1.0)
    kicks = rng.normal(size=samples) * np.sqrt(1.0 - memory**2)
    kicks[0] = rng.normal()
    return lfilter([1.0], [1.0, -memory], kicks)


def with_transient(rng, samples: int, inefficiency: float, size: float, share: float) -> np.ndarray:
    """Correlated noise after a transient of this size that decays within a share of the series."""
    decay = np.exp(-np.arange(samples) / (share * samples)) if share else np.zeros(samples)
    return correlated(rng, samples, inefficiency) + size * decay


def with_drift(rng, samples: int, inefficiency: float, mean: float, change: float) -> np.ndarray:
    """Correlated noise about a mean that changes by ``change`` over the series."""
    line = change * (np.arange(samples) / (samples - 1) - 0.5)
    return mean + line + correlated(rng, samples, inefficiency)
