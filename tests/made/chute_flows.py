"""Made-up chute flows in the paper's units, which by default satisfy all claims."""

from collections.abc import Mapping, Sequence
from math import cos, radians, sin

import numpy as np

from sim.parameters import ChuteParameters
from tests.made.results import SCATTER, MadePoint, made_point, spread

PAPER = ChuteParameters()
SIZE, UNIT = PAPER.diameter, PAPER.velocity_unit
SLOPE = PAPER.gravity * sin(radians(PAPER.angle))

#: Mean velocities in √(gσ) by depth, as in the paper.
SPEEDS = {1: 4.2, 1.24: 4.4, 1.5: 4.5, 2: 4.6, 2.5: 4.8, 3.5: 6, 5: 8.2, 10: 15, 20: 25, 40: 30}

#: Half widths of 95 % intervals of few samples in standard errors.
WIDE = 2.5

#: Packing of a bed that is filled evenly.
PACKING = 0.6


def flow(
    speed: float | Sequence[float],
    scalars: Mapping[str, object] | None = None,
    profiles: Mapping[str, object] | None = None,
    **options: object,
) -> MadePoint:
    """Return a flow at a mean velocity in √(gσ), in balance with its weight.

    ``scalars`` replace the values of such a flow; ``options`` are those of `made_point`.
    """
    settings = {key: value for key, value in options.items() if key in type(PAPER).model_fields}
    point = ChuteParameters(**settings)
    weight = point.particles * point.mass * point.gravity
    down, across = sin(radians(point.angle)), cos(radians(point.angle))
    velocity = UNIT * np.asarray(speed, float)
    power = 0.5 * weight * down * float(np.mean(velocity))
    usual = {
        "velocity": velocity if velocity.ndim else float(velocity),
        "acceleration": 0.0,
        "acceleration_error": 1e-4 * SLOPE,
        "acceleration_half_width": WIDE * 1e-4 * SLOPE,
        "missing_energy": 1e-5,
        "base_normal": weight * across,
        "base_normal_error": 1e-4 * weight,
        "base_shear": weight * down,
        "base_shear_error": 1e-4 * weight,
        "normal_power": power,
        "frictional_power": power,
        "shear_depth": 2 * SIZE,
    }
    options = {"scatter": SCATTER} | options
    return made_point("chute", usual | dict(scalars or {}), profiles, **options)


def base_flows(speeds: Mapping[float, float] = SPEEDS, **options: object) -> list[MadePoint]:
    """Return flows of the base case at velocities by depth."""
    return [flow(speed, depth=depth, **options) for depth, speed in speeds.items()]


def kinked_profile(
    knee: float, depth: float, rest: float = 0.0, replicates: int = 5, scatter: float = SCATTER
) -> np.ndarray:
    """Return velocities (R, H) that rise up to ``knee`` diameters, then ``rest`` times as steeply.

    The knee scatters over replicates.
    """
    height = (np.arange(200) + 0.5) * 0.25
    knees = np.abs(knee * (1 + scatter * spread(replicates)))[:, None]
    shape = np.minimum(height, knees) + rest * np.clip(height - knees, 0, depth)
    return UNIT * shape
