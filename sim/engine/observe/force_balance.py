"""What the plane carries: mean base forces with errors, and the momentum budget of the flow."""

import numpy as np

#: Numbers of blocks that the window is cut into for the errors of the base forces; the largest of
#: their errors is taken.
BLOCKS = (6, 10, 20)


def base_forces(
    shear: np.ndarray,
    normal: np.ndarray,
    velocity: np.ndarray,
    mass: float,
    weight: tuple[float, float],
    interval: float,
) -> dict[str, float]:
    """Return the scalars of a window that the force balance needs, forces in N.

    Parameters
    ----------
    shear, normal : (T,) arrays
        Mean forces on the plane over successive intervals (N).
    velocity : (T,) array
        Mean velocity along the slope over the intervals (m/s).
    mass : float
        Mass of all particles (kg).
    weight : tuple of 2 floats
        Their weight along the slope and normal to it (N).
    interval : float
        Length of an interval (s).
    """
    budget, budget_error = momentum_budget(shear, mass * velocity, interval)
    along, across = weight
    pressed, dragged = _mean(normal), _mean(shear)
    return {
        "base_normal": pressed,
        "base_shear": dragged,
        "normal_balance": pressed / across,
        "shear_balance": dragged / along if along else np.nan,
        "base_normal_error": bounded_error(normal),
        "base_shear_error": bounded_error(shear),
        "momentum_budget": budget,
        "momentum_budget_error": budget_error,
    }


def _mean(series: np.ndarray) -> float:
    return float(series.mean()) if len(series) else np.nan


def bounded_error(series: np.ndarray) -> float:
    """Return the standard error of the mean of a series whose sum stays bounded.

    What the base force of a steady flow lacks of the weight goes into momentum, so its time
    integral is bounded and block means are anticorrelated: the mean over B blocks is off by the
    spread of one block divided by B, not by its square root. Not-a-number with fewer than two
    samples.
    """
    if len(series) < 2:
        return np.nan
    errors = []
    for blocks in BLOCKS:
        parts = np.array_split(series, min(blocks, len(series)))
        errors.append(np.std([part.mean() for part in parts], ddof=1) / len(parts))
    return float(max(errors))


def momentum_budget(
    shear: np.ndarray, momentum: np.ndarray, interval: float
) -> tuple[float, float]:
    """Return mean base shear plus rate of change of momentum, and its standard error (N).

    Newton's second law makes it the weight along the slope, steady or not. The difference of the
    mean momenta of two intervals is the force weighted by a ramp over the one, by 1 between and by
    a ramp over the other; a weight of one half stands for each ramp, and what fluctuates within
    these two intervals (as much as from one to the next) is the error. Not-a-number with fewer
    than two samples.
    """
    if len(shear) < 2:
        return np.nan, np.nan
    weights = np.ones(len(shear))
    weights[[0, -1]] = 0.5
    change = (momentum[-1] - momentum[0]) / (interval * (len(shear) - 1))
    error = shear.std(ddof=1) / (np.sqrt(6) * (len(shear) - 1))
    return float(np.average(shear, weights=weights) + change), float(error)
