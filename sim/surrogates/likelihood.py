"""How probable measurements are, given parameters, by a surrogate.

Measurement i under conditions cᵢ is the surrogate's mean m(θ, cᵢ) with three errors: its own eᵢ;
what the model may lack, d, which differs from one measurement to the next without correlation
(Kennedy and O'Hagan 2001, J. R. Stat. Soc. B 63, 425); and that of the surrogate. The last is one
error where conditions are alike: its covariance is that of the process, S. The measurements are
normal about m with the covariance S + diag(e² + d²). θ is uniform over its ranges, in the scale of
the surrogate; d has a half-normal prior whose scale is the median error.

What was measured flowed. So each measurement also asks for a regime that it allows: one that the
mean is of; or `ARRESTED`, where 0 lies within its 95 % interval, and then the bed at rest gives 0
with the errors e and d. The regimes at neighbouring conditions are one question as well: where the
flow least sure to flow does, the others do. So the least of the probabilities counts, not their
product, and of several measurements of 0 those less sure to flow rest first.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from sim.base.statistics import MANY, student
from sim.surrogates.fit import counted_probability
from sim.surrogates.sample import scaled, unscaled
from sim.surrogates.surrogate import Surrogate

#: The regime of a bed at rest.
ARRESTED = "arrested"

#: Most conditions between which errors of the surrogate are correlated; those of others follow
#: from them (Snelson and Ghahramani 2006, the fully independent training conditional).
_NODES = 24

#: Share of the surrogate's variance that is independent at least: it keeps matrices invertible.
_OWN = 1e-3

#: Numbers of a table that are held at a time.
_MOST_NUMBERS = 4_000_000


@dataclass(frozen=True)
class Predicted:
    """What a surrogate says of m measurements, at n points of θ.

    ``shared`` are errors of the means (n, m) by r independent causes, (n, m, r); ``own`` are
    variances of the rest of these errors, which is independent, (n, m); ``regimes`` has the
    probability of each regime, (regimes, n, m).
    """

    mean: np.ndarray
    shared: np.ndarray
    own: np.ndarray
    regimes: np.ndarray


@dataclass(frozen=True)
class Calibration:
    """Measurements, and the surrogate whose parameters they are to tell.

    ``ranges`` are lowest and highest value of each parameter looked for; ``conditions`` the values
    of all other parameters of the surrogate at each measurement, (m,). Measurements of
    ``observable`` have ``values`` and standard ``errors`` (m,) in the unit of the surrogate.
    ``has_discrepancy`` is whether the model may lack something; the seed is that of the walkers.
    """

    predictor: Surrogate
    ranges: Mapping[str, tuple[float, float]]
    conditions: Mapping[str, np.ndarray]
    values: np.ndarray
    errors: np.ndarray
    observable: str
    has_discrepancy: bool = True
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
        pairs = zip(self.predictor.parameters, self.predictor.scales, strict=True)
        return tuple(scale for name, scale in pairs if name in self.ranges)

    @property
    def usual_error(self) -> float:
        """Median error of the measurements, the scale of the discrepancy."""
        return float(np.median(self.errors))

    @cached_property
    def may_rest(self) -> np.ndarray:
        """Which measurements a bed at rest may have given, (m,)."""
        is_asked = ARRESTED in set(self.predictor.regimes.names) - set(self.predictor.mean_regimes)
        return is_asked & (np.abs(self.values) <= student(MANY) * self.errors)

    def of_theta(self, draws: np.ndarray) -> np.ndarray:
        """Return the points (n, p) of the unit cube of θ of draws as of `log_probability`."""
        return draws[:, : len(self.names)]

    def discrepancy(self, draws: np.ndarray) -> np.ndarray:
        """Return the discrepancy (n, 1) of draws as of `log_probability`."""
        return self.usual_error * draws[:, len(self.names) :].sum(axis=1, keepdims=True)

    def parts(self, draws: np.ndarray) -> Iterator[np.ndarray]:
        """Yield draws in parts whose predictions are held at a time."""
        size = len(self.values) * (len(self._nodes) + len(self.predictor.regimes.names))
        return iter(np.array_split(draws, -(-len(draws) * size // _MOST_NUMBERS) or 1))

    def points(self, shares: np.ndarray, conditions: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return what a predictor takes, (n, m, k), at n points of the unit cube of θ."""
        theta = scaled(shares, self.bounds, self.scales).T[..., None]
        columns = dict(zip(self.names, theta, strict=True)) | dict(conditions)
        return np.stack(
            np.broadcast_arrays(*(columns[name] for name in self.predictor.parameters)), axis=-1
        )

    def predict(self, shares: np.ndarray) -> Predicted:
        """Return what the surrogate says of the measurements at n points of the unit cube of θ."""
        conditions, which = self._distinct
        x = self.points(shares, conditions)
        shape = x.shape[:2]
        flat = x.reshape(-1, x.shape[2])
        mean, error = (one.reshape(shape) for one in self.predictor.predict(flat))
        # Errors at the nodes by independent causes, and what follows of them elsewhere.
        correlation = self.predictor.correlation(x, x[:, self._nodes])
        among = correlation[:, self._nodes] + _OWN * np.eye(len(self._nodes))
        causes = np.linalg.solve(np.linalg.cholesky(among), correlation.transpose(0, 2, 1))
        shared = causes.transpose(0, 2, 1)
        own = np.maximum(0.0, 1 - (shared**2).sum(axis=2))
        regimes = self.predictor.probability(flat).reshape(-1, *shape)
        return Predicted(
            mean[:, which],
            (error[..., None] * shared)[:, which],
            (error**2 * own)[:, which],
            regimes[:, :, which],
        )

    @cached_property
    def _distinct(self) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """The conditions that differ, and which of them each measurement has."""
        if not self.conditions:
            return {}, np.zeros(len(self.values), int)
        table = np.column_stack(list(self.conditions.values()))
        rows, which = np.unique(table, axis=0, return_inverse=True)
        return dict(zip(self.conditions, rows.T, strict=True)), which.ravel()

    @cached_property
    def _nodes(self) -> np.ndarray:
        """Which of the distinct conditions are nodes: each is the farthest from those before."""
        x = self.points(np.full((1, len(self.names)), 0.5), self._distinct[0])[0]
        cube = unscaled(x, self.predictor.bounds, self.predictor.scales)
        nodes, away = [0], np.full(len(cube), np.inf)
        for _ in range(min(_NODES, len(cube)) - 1):
            away = np.minimum(away, ((cube - cube[nodes[-1]]) ** 2).sum(axis=1))
            nodes.append(int(away.argmax()))
        return np.array(nodes)

    def log_probability(self, draws: np.ndarray) -> np.ndarray:
        """Return the logarithm of posterior density (n,), up to a constant.

        ``draws`` (n, p + 1) are θ in the unit cube, and d over `usual_error`; (n, p) without
        a discrepancy.
        """
        most = np.full(draws.shape[1], np.inf)
        most[: len(self.names)] = 1
        inside = ((draws >= 0) & (draws <= most)).all(axis=1)
        densities = np.full(len(draws), -np.inf)
        if inside.any():
            parts = self.parts(draws[inside])
            found = [self.log_density(self.predict(self.of_theta(part)), part) for part in parts]
            densities[inside] = np.concatenate(found)
        return densities

    def log_density(self, predicted: Predicted, draws: np.ndarray) -> np.ndarray:
        """Return what `log_probability` does where θ is inside, and what it predicts is known."""
        count = len(self.names)
        variance = self.errors**2 + self.discrepancy(draws) ** 2
        moves = ~self.may_rest
        distance, size = distances(
            (self.values - predicted.mean)[:, moves],
            predicted.shared[:, moves],
            (variance + predicted.own)[:, moves],
        )
        log_probability = -0.5 * (distance + size + (draws[:, count:] ** 2).sum(axis=1))
        if self.may_rest.any():
            log_probability += _of_some_at_rest(*self.alternatives(predicted, variance))
        with np.errstate(divide="ignore"):
            return log_probability + np.log(self.allowed(predicted.regimes).min(axis=1))

    def allowed(self, regimes: np.ndarray) -> np.ndarray:
        """Return the probability (n, m) of the regimes that each measurement allows."""
        allowed = counted_probability(self.predictor, regimes)
        if self.may_rest.any():
            at_rest = regimes[self.predictor.regimes.names.index(ARRESTED)]
            allowed = allowed + self.may_rest * at_rest
        return allowed

    def alternatives(
        self, predicted: Predicted, variance: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return of the measurements that `may_rest` (n, k) how sure each is to flow, and more.

        The others are the logarithms of the density of its value where it flows and where it
        rests, with the ``variance`` (n, m) of measurement and discrepancy.
        """
        rests = self.may_rest
        at_rest = predicted.regimes[self.predictor.regimes.names.index(ARRESTED)][:, rests]
        allowed = self.allowed(predicted.regimes)[:, rests]
        surety = 1 - at_rest / np.maximum(allowed, np.finfo(float).tiny)
        spread = (predicted.shared**2).sum(axis=2) + predicted.own
        flowing = (variance + spread)[:, rests]
        values, variance = self.values[rests], variance[:, rests]
        return (
            surety,
            -0.5 * ((values - predicted.mean[:, rests]) ** 2 / flowing + np.log(flowing)),
            -0.5 * (values**2 / variance + np.log(variance)),
        )


def distances(
    residuals: np.ndarray, shared: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the squared distances of residuals (n, m) in units of their errors, (n,).

    The covariance of these is ``shared`` (n, m, r) times its transpose, and ``variance`` (n, m) on
    the diagonal. The logarithms of its determinant (n,) come second. Both follow from matrices
    (r, r), by Woodbury's identity.
    """
    weighted = shared / variance[..., None]
    inner = np.eye(shared.shape[2]) + shared.transpose(0, 2, 1) @ weighted
    along = (residuals[:, None] @ weighted)[:, 0]
    explained = (along * np.linalg.solve(inner, along[..., None])[..., 0]).sum(axis=1)
    distance = np.maximum(0.0, (residuals**2 / variance).sum(axis=1) - explained)
    return distance, np.linalg.slogdet(inner)[1] + np.log(variance).sum(axis=1)


def _of_some_at_rest(surety: np.ndarray, flowing: np.ndarray, resting: np.ndarray) -> np.ndarray:
    """Return the logarithm of the density (n,) of values of which the surest k flow, for any k.

    Arguments (n, k) are as `Calibration.alternatives` returns them.
    """
    from scipy.special import logsumexp

    order = np.argsort(-surety, axis=1)
    surety, flowing, resting = (
        np.take_along_axis(one, order, axis=1) for one in (surety, flowing, resting)
    )
    first, last = np.ones((len(surety), 1)), np.zeros((len(surety), 1))
    shares = -np.diff(np.hstack([first, surety, last]), axis=1)
    gains = np.hstack([last, np.cumsum(flowing - resting, axis=1)])
    return np.asarray(logsumexp(gains, b=shares, axis=1) + resting.sum(axis=1))
