"""Made-up predictors: functions whose indices are known, and materials that are measured."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from sim.surrogates.likelihood import Calibration
from sim.surrogates.sample import scaled


@dataclass
class MadePredictor:
    """A function of parameters as a predictor with a constant error, independent everywhere."""

    function: Callable[..., np.ndarray]
    bounds: np.ndarray
    error: float = 0.0
    parameters: tuple[str, ...] = ()
    scales: tuple[str, ...] = field(default=())
    regimes: Any = field(default_factory=lambda: SimpleNamespace(names=("steady",)))
    mean_regimes: tuple[str, ...] = ("steady",)

    def __post_init__(self):
        self.bounds = np.asarray(self.bounds, float)
        self.parameters = self.parameters or tuple(f"x{n}" for n in range(len(self.bounds)))
        self.scales = self.scales or ("linear",) * len(self.bounds)

    def predict(self, x):
        return self.function(*np.asarray(x).T), np.full(len(x), self.error)

    def correlation(self, x, others):
        return (x[:, :, None] == others[:, None]).all(axis=-1).astype(float)

    def probability(self, x):
        return np.ones((1, len(x)))


#: Ishigami and Homma 1990, with a = 7 and b = 0.1.
ISHIGAMI = MadePredictor(
    lambda x, y, z: np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x), [[-np.pi, np.pi]] * 3
)


def ishigami(shares):
    """Return Ishigami's function at points (n, 3) of the unit cube."""
    return ISHIGAMI.predict(scaled(shares, ISHIGAMI.bounds, ISHIGAMI.scales))[0]


#: Exact indices: first order, total, and the one interaction.
ISHIGAMI_FIRST, ISHIGAMI_TOTAL, ISHIGAMI_X_Z = (
    (0.3139, 0.4424, 0.0),
    (0.5576, 0.4424, 0.2437),
    0.2437,
)

#: Coefficients of Sobol's g-function.
G = np.array([0.0, 1.0, 4.5, 9.0])


def g_function(*x):
    return np.prod(
        [(np.abs(4 * one - 2) + a) / (1 + a) for one, a in zip(x, G, strict=True)], axis=0
    )


def product(shares):
    """Return the g-function, with a kink in the middle of each parameter, at points (n, 4)."""
    return g_function(*shares.T)


def g_indices():
    """Return the exact first-order and total indices of the g-function."""
    parts = 1 / (3 * (1 + G) ** 2)
    total_variance = np.prod(1 + parts) - 1
    totals = parts * np.prod(1 + parts) / (1 + parts)
    return parts / total_variance, totals / total_variance


#: Ranges of what is looked for.
RANGES = {"friction": (0.2, 0.8), "restitution": (0.6, 0.98)}

#: Velocity (m/s) as a function of friction, restitution and angle, with an error.
SLOPE = MadePredictor(
    lambda friction, restitution, angle: (
        (angle / 20) ** 2 / (0.3 + friction) * (1 + (angle / 30) * restitution**2)
    ),
    [RANGES["friction"], RANGES["restitution"], (15, 35)],
    error=0.01,
    parameters=("friction", "restitution", "angle"),
)

#: Angles at which it is measured, and relative errors.
ANGLES, ERROR = np.array([18.0, 25.0, 33.0]), 0.03


def made_measurements(seed: int, shift: float = 0.0) -> tuple[dict[str, float], Calibration]:
    """Return a material drawn from the prior, and measurements of it.

    They deviate by their errors, the error of the surrogate and a discrepancy from its prior;
    ``shift`` (m/s) is added to all.
    """
    rng = np.random.default_rng(seed)
    truth = {name: rng.uniform(*ends) for name, ends in RANGES.items()}
    x = np.column_stack([np.full((len(ANGLES), 2), list(truth.values())), ANGLES])
    mean, error = SLOPE.predict(x)
    errors = ERROR * mean
    discrepancy = np.median(errors) * abs(rng.normal())
    spread = np.sqrt(errors**2 + error**2 + discrepancy**2)
    values = mean + spread * rng.normal(size=len(mean)) + shift
    conditions = {"angle": ANGLES}
    return truth, Calibration(SLOPE, RANGES, conditions, values, errors, "velocity", seed)
