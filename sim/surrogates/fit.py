"""The most probable process through values, and through labels of regimes: their probability."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from sim.base.statistics import CONFIDENCE, MANY, student
from sim.study.surrogate import SLOWING
from sim.surrogates.process import Process, matern, on_one_thread
from sim.surrogates.sample import Frame

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

#: Regimes that say nothing of the flow: the run was too short, or gave no value, or the flow still
#: slows down.
UNKNOWN = ("undetermined", SLOWING, "failed")

#: Known variance of a label, ±1.
_EXACT = 1e-4

#: Range of the logarithm of the sharpness of a boundary; before any point, it is 0 ± 1.
_SHARPNESS = (-2.0, 4.0)


def fit_process(
    x: np.ndarray,
    y: np.ndarray,
    variance: np.ndarray,
    has_scatter: bool,
    frames: Sequence[Frame] = (),
) -> Process:
    """Return the process through values (n,) at points (n, d) of the unit cube.

    It goes through them or their logarithms, with an exponent of 5/2 or 3/2, as such or in one of
    some ``frames``: the most probable of all (evidence, with the prior of lengths). Of several
    maxima of a form, the one whose left-out points are most probable is taken. Its errors are
    widened by what points that are left out say of them.
    """
    usable = [None, *(frame for frame in frames if frame.is_usable(x))]
    forms = (False, True) if (y > 0).all() else (False,)
    fitted = [
        fit_lengths(Process(x, y, variance, is_log, has_scatter, exponent=exponent, frame=frame))
        for frame, is_log, exponent in product(usable, forms, _EXPONENTS)
    ]
    return _widened(max(fitted, key=lambda one: one[1])[0])


@on_one_thread
def fit_lengths(process: Process) -> tuple[Process, float]:
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


def _objective(process: Process) -> Callable[[np.ndarray], tuple[float, np.ndarray]]:
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
    ratios = np.sort(local.deviations / local.own_widening())
    outer = ratios[min(number, int(np.ceil(CONFIDENCE * (number + 1)))) - 1]
    widening = student(freedom) / normal * max(1.0, outer / normal)
    widened = replace(local, widening=float(widening))
    return replace(widened, widening=float(widening * _lack(widened)))


def _lack(process: Process) -> float:
    """Return by what factor errors between the points are below those at points left out."""
    lack = process.unexplained_share
    if lack == 0:
        return 1.0
    rng = np.random.default_rng(0)
    places = rng.random((_PLACES, process.x.shape[1]))
    # Between the values of a word there is nothing.
    words = np.isin(process.x, (0, 1)).all(axis=0)
    places[:, words] = process.x[rng.integers(len(process.x), size=_PLACES)][:, words]
    between = np.mean(process.predict(places)[1] ** 2)
    return max(1.0, min(1.0, lack / _UNLEARNED) * np.sqrt(process.unexplained / between))


@dataclass(frozen=True)
class Regimes:
    """The regime at points of the unit cube: a process through labels ±1 for each of them.

    The probability is Φ(a m / √(1 + a² s²)) with mean m and error s of the process. The sharpness
    a is the one that predicts each point best from all others (Rasmussen and Williams 2006,
    section 6.5). Of two regimes, one has a process; those of more are scaled to a sum of 1.
    """

    #: Points, (n, d), and the regime of each, (n,).
    x: np.ndarray
    regime: np.ndarray
    #: Logarithms of sharpness, amplitude, lengths and scatter of each process, (processes, d + 3).
    theta: np.ndarray

    @classmethod
    def fit(cls, x: np.ndarray, regime: np.ndarray, counted: tuple[str, ...] = ()) -> "Regimes":
        """Return the probabilities that the regimes (n,) at points (n, d) give.

        Those of `UNKNOWN` say nothing, unless they are ``counted`` among those of the mean.
        """
        is_known = has_known_regime(regime, counted)
        columns = x.shape[1] + 3
        regimes = cls(x[is_known], regime[is_known], np.zeros((0, columns)))
        fitted = [fit_lengths(regimes.process(name))[0] for name in regimes.process_names]
        rows = [[_sharpness(process), *process.theta] for process in fitted]
        return replace(regimes, theta=np.reshape(rows, (-1, columns)))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The regimes that occur, by name."""
        return tuple(sorted(set(map(str, self.regime))))

    @property
    def process_names(self) -> tuple[str, ...]:
        """The regimes that have a process."""
        return {1: (), 2: self.names[:1]}.get(len(self.names), self.names)

    def process(self, name: str) -> Process:
        """Return the process through the labels of a regime, lengths not fitted."""
        labels = np.where(self.regime == name, 1.0, -1.0)
        variance = np.full(len(labels), _EXACT)
        return Process(self.x, labels, variance, is_log=False, has_scatter=True)

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Return the probability of each regime at points (m, d), (regimes, m)."""
        # Imported here: reading a surrogate's file needs none of it.
        from scipy.special import ndtr

        if len(self.names) < 2:
            return np.ones((len(self.names), len(x)))
        pairs = zip(self.theta, self._processes, strict=True)
        chances = ndtr([_score(theta[0], *process.predict(x)) for theta, process in pairs])
        if len(self.names) == 2:
            return np.vstack([chances, 1 - chances])
        return chances / chances.sum(axis=0)

    @cached_property
    def _processes(self) -> list[Process]:
        pairs = zip(self.process_names, self.theta, strict=True)
        return [replace(self.process(name), theta=theta[1:]) for name, theta in pairs]


def has_known_regime(regime: np.ndarray, counted: tuple[str, ...] = ()) -> np.ndarray:
    """Return for each regime (n,) whether it is certain, or of `UNKNOWN` but counted."""
    return ~np.isin(regime.astype(str), sorted(set(UNKNOWN) - set(counted)))


def counted_probability(surrogate: Any, probability: np.ndarray) -> np.ndarray:
    """Return the probability of the regimes that a mean is of, from that of each (regimes, ...).

    Where no regime is known, none is likelier than these.
    """
    names = surrogate.regimes.names
    if not names:
        return np.ones(probability.shape[1:])
    return np.asarray(probability[np.isin(names, surrogate.mean_regimes)].sum(axis=0))


def _sharpness(process: Process) -> float:
    """Return the logarithm of the sharpness that predicts each label best from the others."""
    # Imported here: reading a surrogate's file needs none of it.
    from scipy.optimize import minimize_scalar
    from scipy.special import log_ndtr

    left_out = process.left_out

    def surprise(sharpness: float) -> float:
        scores = _score(sharpness, left_out.mean, left_out.error)
        return float(sharpness**2 / 2 - log_ndtr(process.y * scores).sum())

    return float(minimize_scalar(surprise, bounds=_SHARPNESS, method="bounded").x)


def _score(sharpness: float, mean: np.ndarray, error: np.ndarray) -> np.ndarray:
    factor = np.exp(sharpness)
    return factor * mean / np.sqrt(1 + (factor * error) ** 2)
