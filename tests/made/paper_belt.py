"""Made-up points of a belt with all results of Gallas, Herrmann and Sokołowski."""

from collections.abc import Callable, Mapping

import numpy as np

from sim.parameters import BeltParameters, parse_point
from tests.made.results import MadePoint, made_point

#: Mean diameter, m.
BEAD = 1e-3


def onset(belt: BeltParameters) -> float:
    """Return the frequency at which transport begins, Hz."""
    return 17.8 if belt.amplitude < 1 else 15.8


def velocity(belt: BeltParameters) -> float:
    """Return the mean velocity, m/s."""
    speed = belt.amplitude * BEAD / np.tan(np.radians(belt.vibration_angle))
    share = 0.6 * np.clip((belt.frequency - onset(belt)) / 3, 1e-4, 1)
    coupled = 1 - np.exp(-belt.shear_damping / 4)
    gentle = (max(belt.shear_damping, 1) / 50) ** (2 / belt.frequency)
    slowed = 1 / (1 + belt.obstacle)
    return speed * 2 * np.pi * belt.frequency * share * coupled * gentle * slowed


def middle_and_width(belt: BeltParameters) -> tuple[float, float]:
    """Return mean and standard deviation of the beads' heights, m."""
    friction = max(belt.damping + belt.shear_damping, 1)
    width = (3.5 + 0.03 * belt.frequency) * (150 / friction) ** 0.2
    return 2.2 * width * BEAD, width * BEAD


def density(belt: BeltParameters) -> Callable[[np.ndarray], np.ndarray]:
    """Return the number density over height, m⁻²: a block at rest, a bell above a gap in flow."""

    def profile(height: np.ndarray) -> np.ndarray:
        if belt.frequency < 15:
            shape = 1.0 * (height < 9 * BEAD)
        else:
            middle, width = middle_and_width(belt)
            shape = np.exp(-0.5 * ((height - middle) / width) ** 2)
            shape[:2] = 0
            shape *= 9.9 / shape.sum()
            shape[:2] = 0.02, 0.08
        return 10 * shape / shape.sum() / BEAD**2

    return profile


def velocity_profile(belt: BeltParameters, lag: float = 0.3) -> Callable:
    """Return the velocity over height, m/s: a plateau, slower at both ends."""
    middle, width = middle_and_width(belt)

    def profile(height: np.ndarray) -> np.ndarray:
        slow = np.abs(height - middle) > 1.5 * width
        return velocity(belt) * np.where(slow, 1 - lag, 1.0)

    return profile


def temperature_profile(belt: BeltParameters) -> Callable:
    """Return the granular temperature over height, m²/s²: hot at the top."""
    middle, width = middle_and_width(belt)
    if belt.frequency < 15:
        return lambda height: np.full(height.size, 1e-6)
    return lambda height: np.where(height > middle + 0.5 * width, 0.05, 0.01)


def paths(belt: BeltParameters) -> dict[str, float]:
    """Return the measures of the particles' paths."""
    free = belt.shear_damping == 0
    drift = 1e-6 if free else velocity(belt) / belt.frequency
    flat = 100 / (belt.damping + belt.shear_damping + 1) * belt.vibration_angle / 45
    height = (0.5 if belt.frequency < 50 or belt.obstacle else 0.1 * flat) * drift
    height *= (1 + belt.obstacle) ** 1.2
    vertical = 7e-4 if belt.frequency < 15 else 5e-4 if free else height
    return {
        "path_drift": drift,
        "path_vertical": vertical,
        "path_vertical_far": vertical,
        "path_major": 7e-4,
        "path_minor": 1e-4,
        "path_tilt": np.radians(85 if belt.shear_damping <= 1 else belt.vibration_angle),
    }


def paper_point(
    scalars: Mapping[str, object] | None = None,
    profiles: Mapping[str, object] | None = None,
    *,
    replicates: int = 5,
    scatter: float = 1e-3,
    height: np.ndarray | None = None,
    **parameters: object,
) -> MadePoint:
    """Return a point of the belt as in the paper, with some values replaced."""
    belt = parse_point({"system": "belt"} | parameters, "tests.made.paper_belt")
    usual = {
        "velocity": velocity(belt),
        "base_occupancy": 0.2 if belt.frequency < 50 else 1e-3,
        "base_occupancy_at_phase_0": 0.2 if belt.frequency < 50 else 1e-3,
        "wave_power": 2.0,
        "early_wave_power": 4.0,
        "backflow": 1e-3,
        **paths(belt),
    }
    number = density(belt)
    shapes = {
        "number_density": number,
        "packing_profile": lambda height: 0.8 * number(height) * BEAD**2,
        "velocity_profile": velocity_profile(belt),
        "granular_temperature_profile": temperature_profile(belt),
        "fluctuation_temperature_profile": temperature_profile(belt),
        "column_velocity": lambda column: np.full(column.size, velocity(belt)),
    }
    return made_point(
        "belt",
        usual | dict(scalars or {}),
        shapes | dict(profiles or {}),
        replicates=replicates,
        scatter=scatter,
        height=height,
        **parameters,
    )
