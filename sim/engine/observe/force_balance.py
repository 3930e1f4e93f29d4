"""Forces in a flow: mean forces on the plane, momentum budget, and local rheology.

Stress ratio and inertial number are those of GDR MiDi, Eur. Phys. J. E 14 (2004) 341. In a local
rheology the stress ratio is a function of the inertial number alone.
"""

import numpy as np

from sim.engine.observe.profiles import ratio

#: Numbers of blocks of the window for the errors of the base forces; the largest error is used.
BLOCKS = (6, 10, 20)


def base_forces(
    shear: np.ndarray,
    normal: np.ndarray,
    velocity: np.ndarray,
    mass: float,
    weight: tuple[float, float],
    interval: float,
) -> dict[str, float]:
    """Return the scalars of the force balance over a window, forces in N.

    ``shear``, ``normal`` and ``velocity`` (T,) are mean forces on the plane (N) and mean velocities
    along the slope (m/s) over successive intervals of a length ``interval`` (s). ``mass`` (kg) and
    ``weight`` (N), along the slope and normal to it, are those of all particles.
    """
    budget, budget_error = momentum_budget(shear, mass * velocity, interval)
    along, across = weight
    mean_normal, mean_shear = _mean(normal), _mean(shear)
    return {
        "base_normal": mean_normal,
        "base_shear": mean_shear,
        "normal_balance": mean_normal / across,
        "shear_balance": mean_shear / along if along else np.nan,
        "base_normal_error": bounded_error(normal),
        "base_shear_error": bounded_error(shear),
        "momentum_budget": budget,
        "momentum_budget_error": budget_error,
    }


def _mean(series: np.ndarray) -> float:
    return float(series.mean()) if len(series) else np.nan


def bounded_error(series: np.ndarray) -> float:
    """Return the standard error of the mean of a series whose sum stays bounded.

    In a steady flow the difference of weight and base force changes the momentum, so its time
    integral is bounded and block means are anticorrelated. The error of the mean over B blocks is
    the spread of the blocks divided by B, not by its square root. Not-a-number with fewer than two
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

    By Newton's second law this is the weight along the slope, steady or not. The difference of the
    mean momenta of two intervals is a weighted sum of the force: a ramp over the first interval, 1
    between them and a ramp over the last. A weight of one half replaces each ramp. The error is the
    fluctuation within these two intervals, assumed equal to that between intervals. Not-a-number
    with fewer than two samples.
    """
    if len(shear) < 2:
        return np.nan, np.nan
    weights = np.ones(len(shear))
    weights[[0, -1]] = 0.5
    change = (momentum[-1] - momentum[0]) / (interval * (len(shear) - 1))
    error = shear.std(ddof=1) / (np.sqrt(6) * (len(shear) - 1))
    return float(np.average(shear, weights=weights) + change), float(error)


def shear_rate(velocity: np.ndarray, slice_height: float, diameter: float) -> np.ndarray:
    """Return du/dz (1/s) over one diameter about each slice of height ``slice_height`` (m).

    Particles of one layer move together, so a shorter distance would resolve the layers. The rate
    is not-a-number within half a diameter of slices without velocity (m/s).
    """
    half = max(1, round(0.5 * diameter / slice_height))
    rate = np.full(velocity.shape, np.nan)
    if velocity.size > 2 * half:
        rate[half:-half] = (velocity[2 * half :] - velocity[: -2 * half]) / (
            2 * half * slice_height
        )
    return rate


def inertial_number(
    rate: np.ndarray, normal: np.ndarray, diameter: float, density: float
) -> np.ndarray:
    """Return I = |du/dz| σ √(ρ/P).

    ``rate`` in 1/s, the normal stress P in Pa, σ in m and the ``density`` ρ of the particles'
    material in kg/m³; not-a-number where there is no normal stress.
    """
    return np.abs(rate) * diameter * np.sqrt(ratio(density, normal))
