"""The local rheology of a sheared flow from its profiles over the height, arrays (H,).

Stress ratio and inertial number are those of GDR MiDi, Eur. Phys. J. E 14 (2004) 341: of a rheology
that is local the first is a function of the second alone.
"""

import numpy as np


def shear_rate(velocity: np.ndarray, slice_height: float, diameter: float) -> np.ndarray:
    """Return du/dz (1/s) over a diameter about each slice of a height (m).

    Particles of one layer move as one, so over less it would be that of their layers. It is
    not-a-number within half a diameter of where there is no velocity (m/s).
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
