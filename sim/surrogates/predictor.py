"""What indices and posteriors ask of a surrogate, and points of the unit cube in its ranges."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike


class Predictor(Protocol):
    """An observable as a function of parameters, with the error of what it says.

    Attributes
    ----------
    parameters : tuple of str
        Names of the parameters, in order.
    bounds : numpy.ndarray
        Lowest and highest value of each, (k, 2).
    scales : tuple of str
        ``linear`` or ``log``: in which scale the values of each are evenly spread.
    regimes : object
        Its ``names`` are those of the regimes that occur.
    mean_regimes : tuple of str
        Regimes that the mean is of.
    """

    @property
    def parameters(self) -> tuple[str, ...]: ...
    @property
    def bounds(self) -> np.ndarray: ...
    @property
    def scales(self) -> tuple[str, ...]: ...
    @property
    def regimes(self) -> Any: ...
    @property
    def mean_regimes(self) -> tuple[str, ...]: ...

    def predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and its standard deviation, (n,) in the observable's unit, at (n, k)."""

    def correlation(self, x: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return how errors of means go together, (g, m, r), at (g, m, k) and (g, r, k)."""

    def probability(self, x: np.ndarray) -> np.ndarray:
        """Return the probability of each regime at (n, k), (regimes, n)."""


def counted_probability(predictor: Predictor, probability: np.ndarray) -> np.ndarray:
    """Return the probability of the regimes that a mean is of, from that of each (regimes, ...).

    Where no regime is known, none is likelier than these.
    """
    names = predictor.regimes.names
    if not names:
        return np.ones(probability.shape[1:])
    return np.asarray(probability[np.isin(names, predictor.mean_regimes)].sum(axis=0))


def scaled(shares: np.ndarray, bounds: ArrayLike, scales: Sequence[str]) -> np.ndarray:
    """Return the values of parameters at points (n, k) of the unit cube."""
    low, high = np.asarray(bounds, float).T
    is_log = np.array([scale == "log" for scale in scales])
    linear = low + (high - low) * shares
    # The ratio of a range that includes 0 is not used.
    ratio = np.where(is_log, high / np.where(is_log, low, 1.0), 1.0)
    return np.where(is_log, low * ratio**shares, linear)


def unscaled(x: np.ndarray, bounds: ArrayLike, scales: Sequence[str]) -> np.ndarray:
    """Return the points of the unit cube that stand for values (n, k), as `scaled` gives them."""
    low, high = np.asarray(bounds, float).T
    is_log = np.array([scale == "log" for scale in scales])
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithmic = np.log(x / low) / np.log(high / low)
    return np.where(is_log, logarithmic, (x - low) / (high - low))
