"""A Gaussian process through numbers with known errors, and what it says of its own errors."""

import warnings
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from sim.base.statistics import CONFIDENCE, MANY, student
from sim.surrogates.threads import on_one_thread

#: Most points from which lengths are fitted; the process goes through all of them.
_MOST_FITTED = 500

#: Points at which a prediction is worked out at a time.
_CHUNK = 2000

#: Least variance of a point, relative to that of all: it keeps the matrix invertible.
_LEAST_VARIANCE = 1e-9

#: Share of the upper bound of a length from which on it is at this bound.
_AT_BOUND = 0.99

#: Ranges of amplitude (variance of the values is 1), lengths (of the unit cube) and scatter.
_AMPLITUDES, _LENGTHS, _SCATTERS = (1e-2, 1e3), (0.05, 20.0), (1e-6, 1.0)


@dataclass(frozen=True)
class LeftOut:
    """Each point as the others predict it.

    ``mean``, ``error`` of that mean and ``noise`` of the point are arrays (n,); errors and noise
    are standard deviations.
    """

    mean: np.ndarray
    error: np.ndarray
    noise: np.ndarray


@dataclass(frozen=True)
class Process:
    """A Gaussian process over the unit cube (Rasmussen and Williams 2006, chapters 2 and 5).

    Its covariance is that of Matérn with exponent 5/2 and a length for each dimension.

    Attributes
    ----------
    x : numpy.ndarray
        Points, (n, d).
    y, variance : numpy.ndarray
        Values (n,), and the known variance of each.
    is_log : bool
        Whether it goes through the logarithms of the values.
    has_scatter : bool
        Whether a scatter besides the known variances is fitted, the same for all points.
    theta : numpy.ndarray
        Logarithms of amplitude, lengths and scatter.
    widening : float
        Factor of the errors of means, see `fit`.
    """

    x: np.ndarray
    y: np.ndarray
    variance: np.ndarray
    is_log: bool
    has_scatter: bool
    theta: np.ndarray = field(default_factory=lambda: np.zeros(0))
    widening: float = 1.0

    @on_one_thread
    def predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return means and their standard deviations (m,) at points (m, d)."""
        parts = [self._predict(x[start : start + _CHUNK]) for start in range(0, len(x), _CHUNK)]
        mean, error = (np.concatenate(part) for part in zip(*parts, strict=True))
        return self._in_unit(mean, self.widening * error)

    def _predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        mean, error = self._regressor.predict(x, return_std=True)
        spread = np.sqrt(np.maximum(0.0, error**2 - self._scatter))
        return self._offset + self._scale * mean, self._scale * spread

    @on_one_thread
    def correlation(self, x: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return how errors of means go together, (g, m, r), at points (g, m, d) and (g, r, d).

        It is that of the process behind the values. With the errors of `predict` it gives their
        covariance in any unit, with logarithms too. Where a point has next to no error, it is 0.
        """
        from scipy.linalg import solve_triangular

        kernel, factor = self._regressor.kernel_, self._regressor.L_
        dimensions = self.x.shape[1]
        origin = np.zeros((1, dimensions))
        variance = float(kernel(origin, origin)[0, 0])

        def known(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            shape = (len(self.y), *points.shape[:2])
            shared = kernel(self.x, points.reshape(-1, dimensions))
            part = solve_triangular(factor, shared, lower=True, check_finite=False).reshape(shape)
            left = np.maximum(variance - (part**2).sum(axis=0), _LEAST_VARIANCE * variance)
            return part.transpose(1, 0, 2), np.sqrt(left)

        # The kernel depends on the distance alone.
        apart = (x[:, :, None] - others[:, None]).reshape(-1, dimensions)
        prior = kernel(apart, origin).reshape(len(x), x.shape[1], -1)
        (first, spread), (second, spread_of_others) = known(x), known(others)
        covariance = prior - first.transpose(0, 2, 1) @ second
        return covariance / (spread[:, :, None] * spread_of_others[:, None])

    @on_one_thread
    def left_out(self) -> LeftOut:
        """Return each point as the others predict it, lengths unchanged, without `widening`.

        Rasmussen and Williams (2006), equations 5.10 to 5.12.
        """
        from scipy.linalg import cho_solve

        regressor = self._regressor
        inverse = cho_solve((regressor.L_, True), np.eye(len(self.y))).diagonal()
        noise = self._known / self._scale**2 + self._scatter
        mean = regressor.y_train_ - regressor.alpha_ / inverse
        error = np.sqrt(np.maximum(0.0, 1 / inverse - noise))
        middle, spread = self._in_unit(self._offset + self._scale * mean, self._scale * error)
        unit = np.abs(middle) if self.is_log else 1.0
        return LeftOut(middle, spread, self._scale * np.sqrt(noise) * unit)

    @property
    def at_bound(self) -> np.ndarray:
        """Which dimensions (d,) have a length at its upper bound: their effect is not told."""
        lengths = self.theta[1 : 1 + self.x.shape[1]]
        return np.asarray(lengths >= np.log(_AT_BOUND * _LENGTHS[1]))

    @cached_property
    def _values(self) -> np.ndarray:
        return np.log(self.y) if self.is_log else self.y

    @cached_property
    def _known(self) -> np.ndarray:
        return self.variance / self.y**2 if self.is_log else self.variance

    @property
    def _offset(self) -> float:
        return float(self._values.mean())

    @property
    def _scale(self) -> float:
        return float(self._values.std()) or 1.0

    @property
    def _scatter(self) -> float:
        return float(np.exp(self.theta[-1])) if self.has_scatter else 0.0

    @cached_property
    def _regressor(self) -> Any:
        kernel = _kernel(self.x.shape[1], self.has_scatter).clone_with_theta(self.theta)
        return self.regressor(kernel, slice(None), optimizer=None)

    @on_one_thread
    def regressor(self, kernel: Any, part: Any, **options: Any) -> Any:
        """Return the regressor of scikit-learn through a part of the points, values scaled."""
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor

        noise = np.maximum(self._known[part] / self._scale**2, _LEAST_VARIANCE)
        values = (self._values[part] - self._offset) / self._scale
        with warnings.catch_warnings():
            # A length at the end of its range is a parameter without effect.
            warnings.simplefilter("ignore", ConvergenceWarning)
            return GaussianProcessRegressor(kernel, alpha=noise, **options).fit(
                self.x[part], values
            )

    def _in_unit(self, mean: np.ndarray, error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and error in the unit of the values.

        With logarithms, the error gives the half width of the interval, which is not symmetric.
        """
        if not self.is_log:
            return mean, error
        normal = float(student(MANY))
        return np.exp(mean), np.exp(mean) * np.sinh(np.minimum(normal * error, 50.0)) / normal


def fit(x: np.ndarray, y: np.ndarray, variance: np.ndarray, has_scatter: bool) -> Process:
    """Return the process through values (n,) at points (n, d), or through their logarithms.

    The better of both is the one whose points, left out one by one, are predicted better. Two
    factors widen its errors. Lengths are fitted to few points, so Student's distribution takes the
    place of the normal one, with a degree of freedom less for each. And a process whose lengths are
    the same everywhere is too sure next to a kink: 95 % of the points, left out one by one, must
    lie within their intervals.
    """
    forms = (False, True) if (y > 0).all() else (False,)
    fitted = [fit_lengths(Process(x, y, variance, is_log, has_scatter)) for is_log in forms]
    best = min(fitted, key=lambda one: np.mean((one.left_out().mean - y) ** 2))
    freedom, number = max(2, len(y) - len(best.theta)), len(y)
    normal = float(student(MANY))
    widening = np.sqrt(number / freedom) * student(freedom) / normal
    ratios = np.sort(deviations(best.left_out(), y))
    outer = ratios[min(number, int(np.ceil(CONFIDENCE * (number + 1)))) - 1]
    return replace(best, widening=float(widening * max(1.0, outer / normal)))


def fit_lengths(process: Process) -> Process:
    """Return a process with the amplitude, lengths and scatter of greatest marginal likelihood."""
    order = np.random.default_rng(0).permutation(len(process.y))[:_MOST_FITTED]
    kernel = _kernel(process.x.shape[1], process.has_scatter)
    fitted = process.regressor(kernel, np.sort(order), n_restarts_optimizer=1, random_state=0)
    return replace(process, theta=fitted.kernel_.theta)


def deviations(left_out: LeftOut, y: np.ndarray) -> np.ndarray:
    """Return how far values (n,) are from what the others predict, in standard deviations."""
    spread = np.hypot(left_out.error, left_out.noise)
    return np.abs(left_out.mean - y) / np.maximum(spread, np.finfo(float).tiny)


def _kernel(dimensions: int, has_scatter: bool) -> Any:
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    kernel = ConstantKernel(1.0, _AMPLITUDES) * Matern(np.ones(dimensions), _LENGTHS, nu=2.5)
    return kernel + WhiteKernel(1e-2, _SCATTERS) if has_scatter else kernel
