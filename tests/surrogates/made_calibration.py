"""Made-up materials whose velocity on a slope is measured, and how often a posterior holds them."""

import numpy as np

from sim.surrogates.likelihood import Calibration
from tests.surrogates.predictors import MadePredictor

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
