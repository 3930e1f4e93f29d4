"""Made-up predictors: functions whose indices are known, and materials that are measured."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from sim.surrogates.likelihood import Calibration
from sim.verify import exact


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


#: Ishigami's function of the unit cube.
ISHIGAMI = MadePredictor(lambda *x: exact.ishigami(np.stack(x, axis=1)), [[0, 1]] * 3)

#: Exact indices of it: first order, total, and the one interaction.
ISHIGAMI_FIRST, ISHIGAMI_TOTAL = exact.ISHIGAMI.reshape(2, 3)
ISHIGAMI_X_Z = exact.ISHIGAMI[5]


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
