"""The probability of each regime between points whose regime is known."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sim.study.surrogate import SLOWING
from sim.surrogates.process import Process

#: Regimes that say nothing of the flow: the run was too short, or gave no value, or the flow still
#: slows down.
UNKNOWN = ("undetermined", SLOWING, "failed")

#: Known variance of a label, ±1.
_EXACT = 1e-4

#: Range of the logarithm of the sharpness of a boundary; before any point, it is 0 ± 1.
_SHARPNESS = (-2.0, 4.0)


@dataclass(frozen=True)
class Regimes:
    """The regime at points of the unit cube: a process through labels ±1 for each of them.

    The probability is Φ(a m / √(1 + a² s²)) with mean m and error s of the process. The sharpness
    a is the one that predicts each point best from all others (Rasmussen and Williams 2006,
    section 6.5). Of two regimes, one has a process; those of more are scaled to a sum of 1.

    Attributes
    ----------
    x : numpy.ndarray
        Points, (n, d).
    regime : numpy.ndarray
        The regime of each, (n,).
    theta : numpy.ndarray
        Logarithms of sharpness, amplitude, lengths and scatter of each process,
        (processes, d + 3).
    """

    x: np.ndarray
    regime: np.ndarray
    theta: np.ndarray

    @classmethod
    def fit(cls, x: np.ndarray, regime: np.ndarray, counted: tuple[str, ...] = ()) -> "Regimes":
        """Return the probabilities that the regimes (n,) at points (n, d) give.

        Those of `UNKNOWN` say nothing, unless they are ``counted`` among those of the mean.
        """
        is_known = has_known_regime(regime, counted)
        x, regime = x[is_known], regime[is_known]
        start = cls(x, regime, np.zeros((0, x.shape[1] + 3)))
        rows = []
        for name in start.process_names:
            process = start.process(name).fit_lengths()
            rows.append([_sharpness(process), *process.theta])
        return replace(start, theta=np.reshape(rows, (-1, x.shape[1] + 3)))

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
        return [
            replace(self.process(name), theta=theta[1:])
            for name, theta in zip(self.process_names, self.theta, strict=True)
        ]


def has_known_regime(regime: np.ndarray, counted: tuple[str, ...] = ()) -> np.ndarray:
    """Return for each regime (n,) whether it is certain, or of `UNKNOWN` but counted."""
    return ~np.isin(regime.astype(str), sorted(set(UNKNOWN) - set(counted)))


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
