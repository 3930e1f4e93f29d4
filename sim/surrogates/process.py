"""A Gaussian process through numbers with known errors, and what it says of its own errors."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, cached_property, wraps
from typing import Any, NamedTuple, TypeVar

import numpy as np

from sim.base.statistics import MANY, student
from sim.surrogates.sample import Frame

#: Points at which a prediction is worked out at a time.
_CHUNK = 2000

#: Least variance of a point, relative to that of all: it keeps the matrix invertible.
_LEAST_VARIANCE = 1e-9

#: Weight of the mean of all points, in points, where errors are widened by those nearby.
_PRIOR_WEIGHT = 2.0

Function = TypeVar("Function", bound=Callable[..., Any])


def on_one_thread(function: Function) -> Function:
    """Return a function during which BLAS computes on one thread.

    The matrices of surrogates are small: threads wait for each other longer than they compute
    (twelve times the processor time with two threads on two busy cores).
    """

    @wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        with _controller().limit(limits=1, user_api="blas"):
            return function(*args, **options)

    return call  # type: ignore[return-value]


@cache
def _controller() -> Any:
    """Return the controller of the threads of BLAS, once scikit-learn has loaded it."""
    import sklearn.gaussian_process  # noqa: F401  # it loads them
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


class LeftOut(NamedTuple):
    """Each point as the others predict it, arrays (n,).

    ``error`` of the ``mean`` and ``noise`` of the point are standard deviations.
    """

    mean: np.ndarray
    error: np.ndarray
    noise: np.ndarray


@dataclass(frozen=True)
class Process:
    """A Gaussian process over the unit cube (Rasmussen and Williams 2006, chapters 2 and 5).

    Its covariance is that of Matérn with a length for each dimension.
    """

    #: Points (n, d), values (n,), and the known variance of each.
    x: np.ndarray
    y: np.ndarray
    variance: np.ndarray
    #: Whether it goes through the logarithms of the values.
    is_log: bool
    #: Whether a scatter besides the known variances is fitted, the same for all points.
    has_scatter: bool
    #: Logarithms of amplitude, lengths and scatter.
    theta: np.ndarray = field(default_factory=lambda: np.zeros(0))
    #: Factor of the errors of means, see `sim.surrogates.fit.fit_process`.
    widening: float = 1.0
    #: Exponent of the covariance: 5/2 for smooth functions, 3/2 for those with kinks.
    exponent: float = 2.5
    #: Groups of parameters in which it lives, and the scale of the values.
    frame: Frame | None = None
    #: Whether errors are wider near points that lie outside of what the others expect.
    is_local: bool = False

    @on_one_thread
    def predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return means and their standard deviations (m,) at points (m, d)."""
        parts = [self._predict(part) for part in np.split(x, range(_CHUNK, len(x), _CHUNK))]
        mean, error = map(np.concatenate, zip(*parts, strict=True))
        return mean, error

    def _predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        places = self.places_of(x)
        mean, error = self._regressor.predict(places, return_std=True)
        spread = self.widening * np.sqrt(np.maximum(0.0, error**2 - self._scatter))
        if self.is_local:
            spread *= self._local_widening(self._prior_correlation(places))
        return self._in_unit(mean, spread, self._scale_at(x))

    def places_of(self, x: np.ndarray) -> np.ndarray:
        """Return where points of the unit cube lie for its covariance, (n, k)."""
        if self.frame is None:
            return x
        low, width = self._extent
        return (self.frame.places(x) - low) / width

    @cached_property
    def _extent(self) -> tuple[np.ndarray, np.ndarray]:
        assert self.frame is not None, "asked for where groups are scaled"
        places = self.frame.places(self.x)
        width = np.ptp(places, axis=0)
        return places.min(axis=0), np.where(width > 0, width, 1.0)

    @cached_property
    def places(self) -> np.ndarray:
        """Where its points lie for its covariance, (n, k)."""
        return self.places_of(self.x)

    def _scale_at(self, x: np.ndarray) -> np.ndarray:
        return np.ones(len(x)) if self.frame is None else self.frame.scale(x)

    @cached_property
    def scales(self) -> np.ndarray:
        """Scale of the values at its points, (n,)."""
        return self._scale_at(self.x)

    def _prior_correlation(self, places: np.ndarray) -> np.ndarray:
        """Return the correlation of the values at places (m, k) and at its points, (m, n)."""
        from scipy.spatial.distance import cdist

        distance = cdist(places / self._lengths, self.places / self._lengths)
        return matern(distance, self.exponent)[0]

    def _local_widening(self, correlation: np.ndarray) -> np.ndarray:
        """Return by how much errors widen where points nearby lie outside of what others expect.

        It is the root of a mean of squared `deviations`, weighted by the correlation (m, n).
        """
        weights = correlation.sum(axis=1) + _PRIOR_WEIGHT
        squares = correlation @ self.deviations**2
        return np.sqrt(np.maximum(1.0, (_PRIOR_WEIGHT + squares) / weights))

    def own_widening(self) -> np.ndarray:
        """Return the local widening at each point that the others give, (n,)."""
        correlation = self._prior_correlation(self.places)
        np.fill_diagonal(correlation, 0.0)
        return self._local_widening(correlation) if self.is_local else np.ones(len(self.y))

    @on_one_thread
    def correlation(self, x: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return how errors of means go together, (g, m, r), at points (g, m, d) and (g, r, d).

        It is that of the process behind the values. With the errors of `predict` it gives their
        covariance in any unit, with logarithms too. Where a point has next to no error, it is 0.
        """
        from scipy.linalg import solve_triangular

        kernel, factor = self._regressor.kernel_, self._regressor.L_
        dimensions = self.places.shape[1]
        x, others = (
            self.places_of(one.reshape(-1, one.shape[2])).reshape(*one.shape[:2], dimensions)
            for one in (x, others)
        )
        origin = np.zeros((1, dimensions))
        variance = float(kernel(origin, origin)[0, 0])

        def known(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            shape = (len(self.y), *points.shape[:2])
            shared = kernel(self.places, points.reshape(-1, dimensions))
            part = solve_triangular(factor, shared, lower=True, check_finite=False).reshape(shape)
            left = np.maximum(variance - (part**2).sum(axis=0), _LEAST_VARIANCE * variance)
            return part.transpose(1, 0, 2), np.sqrt(left)

        # The kernel depends on the distance alone.
        apart = (x[:, :, None] - others[:, None]).reshape(-1, dimensions)
        prior = kernel(apart, origin).reshape(len(x), x.shape[1], -1)
        (first, spread), (second, spread_of_others) = known(x), known(others)
        covariance = prior - first.transpose(0, 2, 1) @ second
        return covariance / (spread[:, :, None] * spread_of_others[:, None])

    @cached_property
    def left_out(self) -> LeftOut:
        """Each point as the others predict it, lengths unchanged, without `widening`.

        Rasmussen and Williams (2006), equations 5.10 to 5.12.
        """
        mean, spread = self.left_out_values()
        noise = np.sqrt(self._known / self._scale**2 + self._scatter)
        error = np.sqrt(np.maximum(0.0, spread**2 - noise**2))
        middle, error = self._in_unit(mean, error, self.scales)
        unit = np.abs(middle) if self.is_log else self.scales
        return LeftOut(middle, error, self._scale * noise * unit)

    @on_one_thread
    def left_out_values(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the scaled values that others predict, and the deviations of runs from them."""
        from scipy.linalg import cho_solve

        regressor = self._regressor
        inverse = cho_solve((regressor.L_, True), np.eye(len(self.y))).diagonal()
        return regressor.y_train_ - regressor.alpha_ / inverse, np.sqrt(1 / inverse)

    @cached_property
    def deviations(self) -> np.ndarray:
        """How far each value is from what the others predict, in standard deviations, (n,)."""
        spread = np.hypot(self.left_out.error, self.left_out.noise)
        return np.abs(self.left_out.mean - self.y) / np.maximum(spread, np.finfo(float).tiny)

    @cached_property
    def unexplained(self) -> float:
        """Variance of the points that the others do not tell, less their own noise; at least 0."""
        left_out = self.left_out
        apart = np.mean((left_out.mean - self.y) ** 2) - np.mean(left_out.noise**2)
        return max(0.0, float(apart))

    @property
    def unexplained_share(self) -> float:
        """Share of the variance between its points that the others do not tell."""
        return self.unexplained / (float(np.var(self.y)) or 1.0)

    @cached_property
    def values(self) -> np.ndarray:
        """Values (n,) in the scale of the frame, or their logarithms: mean 0, variance 1."""
        return (self._values - self._offset) / self._scale

    @cached_property
    def noise(self) -> np.ndarray:
        """Known variance of each of `values`, (n,)."""
        return np.maximum(self._known / self._scale**2, _LEAST_VARIANCE)

    @property
    def log_unit(self) -> float:
        """Logarithm of the density of the values y over that of `values`."""
        jacobian = np.log(self.scales).sum() + len(self.y) * np.log(self._scale)
        return -float(jacobian + (self._values.sum() if self.is_log else 0.0))

    @cached_property
    def _values(self) -> np.ndarray:
        scaled = self.y / self.scales
        return np.log(scaled) if self.is_log else scaled

    @cached_property
    def _known(self) -> np.ndarray:
        return self.variance / (self.y if self.is_log else self.scales) ** 2

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
    def _lengths(self) -> np.ndarray:
        return np.exp(self.theta[1 : 1 + self.places.shape[1]])

    @cached_property
    @on_one_thread
    def _regressor(self) -> Any:
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

        kernel = ConstantKernel(np.exp(self.theta[0])) * Matern(self._lengths, nu=self.exponent)
        if self.has_scatter:
            kernel += WhiteKernel(self._scatter)
        regressor = GaussianProcessRegressor(kernel, alpha=self.noise, optimizer=None)
        return regressor.fit(self.places, self.values)

    def _in_unit(
        self, mean: np.ndarray, error: np.ndarray, scale: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and error of `values` in the unit of y, where the frame has a scale.

        With logarithms, the error gives the half width of the interval, which is not symmetric.
        """
        mean, error = self._offset + self._scale * mean, self._scale * error
        if not self.is_log:
            return scale * mean, scale * error
        normal, mean = float(student(MANY)), scale * np.exp(mean)
        return mean, mean * np.sinh(np.minimum(normal * error, 50.0)) / normal


def matern(distance: np.ndarray, exponent: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Matérn's correlation at distances, and its derivative by -log length over r²."""
    root = np.sqrt(2 * exponent) * distance
    decay = np.exp(-root)
    if exponent == 1.5:
        return (1 + root) * decay, 3 * decay
    return (1 + root + root**2 / 3) * decay, 5 / 3 * (1 + root) * decay
