"""The local rheology of a sheared flow from its profiles over the height, arrays (H,).

Stress ratio and inertial number are those of GDR MiDi, Eur. Phys. J. E 14 (2004) 341. In a local
rheology the stress ratio is a function of the inertial number alone.
"""

import numpy as np


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


def stress_ratio(shear: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return shear over normal stress, not-a-number where there is no normal stress."""
    ratio = np.full(shear.shape, np.nan)
    np.divide(shear, normal, out=ratio, where=normal > 0.0)
    return ratio


def inertial_number(
    rate: np.ndarray, normal: np.ndarray, diameter: float, density: float
) -> np.ndarray:
    """Return I = |du/dz| σ √(ρ/P).

    ``rate`` in 1/s, the normal stress P in Pa, σ in m and the ``density`` ρ of the particles'
    material in kg/m³; not-a-number where there is no normal stress.
    """
    number = np.full(rate.shape, np.nan)
    np.divide(density, normal, out=number, where=normal > 0.0)
    return np.abs(rate) * diameter * np.sqrt(number)
