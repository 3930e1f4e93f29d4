"""Synthetic series: correlated noise with a known mean, transient and drift."""

import numpy as np
from scipy.signal import lfilter


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
