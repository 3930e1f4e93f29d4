"""A Gaussian process through numbers with known errors, and what it says of its own errors."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from sim.base.statistics import CONFIDENCE, MANY, student
from sim.surrogates.predictor import Frame, on_one_thread

#: Points at which a prediction is worked out at a time.
_CHUNK = 2000

#: Least variance of a point, relative to that of all: it keeps the matrix invertible.
_LEAST_VARIANCE = 1e-9

#: Weight of the mean of all points, in points, where errors are widened by those nearby.
_PRIOR_WEIGHT = 2.0


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

    Its covariance is that of Matérn with a length for each dimension.

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
    exponent : float
        Exponent of the covariance: 5/2 for smooth functions, 3/2 for those with kinks.
    frame : Frame, optional
        Groups of parameters in which it lives, and the scale of the values.
    is_local : bool
        Whether errors are wider near points that lie outside of what the others expect.
    """

    x: np.ndarray
    y: np.ndarray
    variance: np.ndarray
    is_log: bool
    has_scatter: bool
    theta: np.ndarray = field(default_factory=lambda: np.zeros(0))
    widening: float = 1.0
    exponent: float = 2.5
    frame: Frame | None = None
    is_local: bool = False

    @classmethod
    def fit(
        cls,
        x: np.ndarray,
        y: np.ndarray,
        variance: np.ndarray,
        has_scatter: bool,
        frames: Sequence[Frame] = (),
    ) -> "Process":
        """Return the process through values (n,) at points (n, d) of the unit cube.

        It goes through them or their logarithms, with an exponent of 5/2 or 3/2, as such or in one
        of some ``frames``: the most probable of all (evidence, with the prior of lengths). Of
        several maxima of a form, the one whose left-out points are most probable is taken. Its
        errors are widened by what points that are left out say of them.
        """
        usable = [None, *(frame for frame in frames if frame.is_usable(x))]
        forms = (False, True) if (y > 0).all() else (False,)
        fitted = [
            _fitted(cls(x, y, variance, is_log, has_scatter, exponent=exponent, frame=frame))
            for frame, is_log, exponent in product(usable, forms, _EXPONENTS)
        ]
        return _widened(max(fitted, key=lambda one: one[1])[0])

    def fit_lengths(self) -> "Process":
        """Return the process with the most probable amplitude, lengths and scatter."""
        return _fitted(self)[0]

    @on_one_thread
    def predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return means and their standard deviations (m,) at points (m, d)."""
        parts = [self._predict(x[start : start + _CHUNK]) for start in range(0, len(x), _CHUNK)]
        mean, error = (np.concatenate(part) for part in zip(*parts, strict=True))
        return mean, error

    def _predict(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        places = self.places_of(x)
        mean, error = self._regressor.predict(places, return_std=True)
        spread = self.widening * np.sqrt(np.maximum(0.0, error**2 - self._scatter))
        if self.is_local:
            spread *= self._local_widening(self._prior_correlation(places))
        values = self._offset + self._scale * mean, self._scale * spread
        return self._in_unit(*values, self._scale_at(x))

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
        squares = deviations(self.left_out, self.y) ** 2
        weights = correlation.sum(axis=1) + _PRIOR_WEIGHT
        return np.sqrt(np.maximum(1.0, (_PRIOR_WEIGHT + correlation @ squares) / weights))

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
        values = self._offset + self._scale * mean, self._scale * error
        middle, error = self._in_unit(*values, self.scales)
        unit = np.abs(middle) if self.is_log else self.scales
        return LeftOut(middle, error, self._scale * noise * unit)

    @cached_property
    def unexplained(self) -> float:
        """Variance of the points that the others do not tell, less their own noise; at least 0."""
        left_out = self.left_out
        apart = np.mean((left_out.mean - self.y) ** 2) - np.mean(left_out.noise**2)
        return max(0.0, float(apart))

    @on_one_thread
    def left_out_values(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the scaled values that others predict, and the deviations of runs from them."""
        from scipy.linalg import cho_solve

        regressor = self._regressor
        inverse = cho_solve((regressor.L_, True), np.eye(len(self.y))).diagonal()
        return regressor.y_train_ - regressor.alpha_ / inverse, np.sqrt(1 / inverse)

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
        """Return mean and error in the unit of the values.

        With logarithms, the error gives the half width of the interval, which is not symmetric.
        """
        if not self.is_log:
            return scale * mean, scale * error
        normal, mean = float(student(MANY)), scale * np.exp(mean)
        return mean, mean * np.sinh(np.minimum(normal * error, 50.0)) / normal


def deviations(left_out: LeftOut, y: np.ndarray) -> np.ndarray:
    """Return how far values (n,) are from what the others predict, in standard deviations."""
    spread = np.hypot(left_out.error, left_out.noise)
    return np.abs(left_out.mean - y) / np.maximum(spread, np.finfo(float).tiny)


def matern(distance: np.ndarray, exponent: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Matérn's correlation at distances, and its derivative by -log length over r²."""
    root = np.sqrt(2 * exponent) * distance
    decay = np.exp(-root)
    if exponent == 1.5:
        return (1 + root) * decay, 3 * decay
    return (1 + root + root**2 / 3) * decay, 5 / 3 * (1 + root) * decay


#: Most points from which lengths are fitted; the process goes through all of them.
_MOST_FITTED = 500

#: Ranges of amplitude (variance of the values is 1), lengths (of the unit cube) and scatter.
_AMPLITUDES, LENGTHS, _SCATTERS = (1e-2, 1e3), (0.05, 20.0), (1e-6, 1.0)

#: Mean and deviation of the logarithm of a length before any point is known: a parameter without
#: effect has a length of a few ranges, not of any number of them.
_PRIOR = (0.5, 1.5)

#: Starts of a fit besides the first, for fewer points than these; drawn about a length of 0.6.
_RESTARTS, _FEW, _START = 3, 150, -0.5

#: Exponents of the covariance that are tried.
_EXPONENTS = (2.5, 1.5)

#: Share of the variance that points do not tell of each other above which a process has not learned
#: its function; and places where its errors are then looked at.
_UNLEARNED, _PLACES = 0.03, 500

Objective = Callable[[np.ndarray], tuple[float, np.ndarray]]


@on_one_thread
def _fitted(process: Process) -> tuple[Process, float]:
    """Return a process with its most probable lengths, and the logarithm of its evidence."""
    # Imported here: reading a surrogate's file needs none of it.
    from scipy.optimize import minimize

    dimensions, rng = process.places.shape[1], np.random.default_rng(0)
    first = np.log([1.0, *np.ones(dimensions), *([1e-2] if process.has_scatter else [])])
    bounds = np.log([_AMPLITUDES, *[LENGTHS] * dimensions, *[_SCATTERS] * process.has_scatter])
    starts = [first]
    for _ in range(_RESTARTS if len(process.y) < _FEW else 1):
        start = first.copy()
        start[1 : 1 + dimensions] = rng.normal(_START, 1.0, dimensions)
        starts.append(np.clip(start, *bounds.T))
    objective = _objective(process)
    ends = [minimize(objective, one, jac=True, method="L-BFGS-B", bounds=bounds) for one in starts]
    found = [(replace(process, theta=end.x), process.log_unit - float(end.fun)) for end in ends]
    return max(found, key=lambda one: _left_out_density(one[0]))


def _left_out_density(process: Process) -> float:
    """Return the logarithm of the density of all points, each as the others predict it.

    Of several maxima, that of greatest evidence may take a function that it misses for noise.
    Rasmussen and Williams (2006), equations 5.10 and 5.11.
    """
    mean, spread = process.left_out_values()
    return -float(np.sum(((mean - process.values) / spread) ** 2 / 2 + np.log(spread)))


def _objective(process: Process) -> Objective:
    """Return the negative logarithm of evidence and prior, with its gradient, of theta.

    Rasmussen and Williams (2006), equations 5.8 and 5.9.
    """
    from scipy.linalg import lapack

    order = np.random.default_rng(0).permutation(len(process.y))[:_MOST_FITTED]
    places, values, noise = process.places[order], process.values[order], process.noise[order]
    count, dimensions = places.shape
    squares = ((places.T[:, :, None] - places.T[:, None, :]) ** 2).reshape(dimensions, -1)
    mean, deviation = _PRIOR

    def objective(theta: np.ndarray) -> tuple[float, np.ndarray]:
        amplitude, lengths = np.exp(theta[0]), theta[1 : 1 + dimensions]
        scatter = np.exp(theta[-1]) if process.has_scatter else 0.0
        inverse = np.exp(-2 * lengths)
        distance = np.sqrt(inverse @ squares).reshape(count, count)
        correlation, slope = matern(distance, process.exponent)
        covariance = amplitude * correlation
        covariance.flat[:: count + 1] += noise + scatter
        factor, failed = lapack.dpotrf(covariance, lower=1, clean=1)
        if failed:
            return np.inf, np.zeros_like(theta)
        lower, _ = lapack.dpotri(factor, lower=1)
        precision = np.tril(lower) + np.tril(lower, -1).T
        weights = precision @ values
        apart = (lengths - mean) / deviation
        surprise = 0.5 * (values @ weights + count * np.log(2 * np.pi) + apart @ apart)
        shares = 0.5 * (precision - np.outer(weights, weights))
        gradient = np.zeros_like(theta)
        gradient[0] = amplitude * np.sum(shares * correlation)
        gradient[1 : 1 + dimensions] = inverse * (squares @ (amplitude * shares * slope).ravel())
        gradient[1 : 1 + dimensions] += apart / deviation
        if process.has_scatter:
            gradient[-1] = scatter * np.trace(shares)
        return float(surprise + np.log(factor.diagonal()).sum()), gradient

    return objective


def _widened(process: Process) -> Process:
    """Return a process whose errors hold what points that are left out say of them.

    Lengths are fitted to few points, so Student's distribution takes the place of the normal one,
    with a degree of freedom less for each. A process whose lengths are the same everywhere is too
    sure next to a kink: errors widen near points that the others do not expect, and 95 % of the
    points, left out one by one, must lie within their intervals. Where the points leave much of
    each other unexplained, errors between them are as large as theirs.
    """
    freedom, number = max(2, len(process.y) - len(process.theta)), len(process.y)
    normal = float(student(MANY))
    local = replace(process, is_local=True)
    ratios = np.sort(deviations(local.left_out, local.y) / local.own_widening())
    outer = ratios[min(number, int(np.ceil(CONFIDENCE * (number + 1)))) - 1]
    widening = student(freedom) / normal * max(1.0, outer / normal)
    widened = replace(local, widening=float(widening))
    return replace(widened, widening=float(widening * _lack(widened)))


def _lack(process: Process) -> float:
    """Return by what factor errors between the points are below those at points left out."""
    apart = process.unexplained
    lack = apart / (np.var(process.y) or 1.0)
    if lack == 0:
        return 1.0
    rng = np.random.default_rng(0)
    places = rng.random((_PLACES, process.x.shape[1]))
    # Between the values of a word there is nothing.
    words = np.isin(process.x, (0, 1)).all(axis=0)
    places[:, words] = process.x[rng.integers(len(process.x), size=_PLACES)][:, words]
    between = np.mean(process.predict(places)[1] ** 2)
    return max(1.0, min(1.0, lack / _UNLEARNED) * np.sqrt(apart / between))
