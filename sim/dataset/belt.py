"""Profiles along the belt and over its cycle, from run files, and the velocity of the belt."""

from collections.abc import Mapping
from math import nan, pi
from typing import Any

import numpy as np

from sim.dataset.run_file import NamedValues


def speed_along_x(belt: NamedValues) -> Any:
    """Return the amplitude of the belt's velocity along x, A_x 2πf (m/s), for one point or many."""
    amplitude = belt["amplitude"] * belt["diameter"] / np.tan(np.radians(belt["vibration_angle"]))
    return amplitude * 2 * pi * belt["frequency"]


#: Profiles over the cycle of the vibration, each with the time series that it averages.
OVER_CYCLE = {
    "cycle_normal_force": "belt_normal_force",
    "cycle_shear_force": "belt_shear_force",
    "cycle_contact_time": "belt_contact_time",
}


def column_means(run: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return velocity and density along the belt, averaged over all levels of the field.

    Returns
    -------
    dict
        ``column_velocity`` (m/s) and ``column_density`` (beads per length, m⁻¹), each over
        (replicate, square), and ``column`` (square,), the centres of the squares along the belt
        (m). Empty for a run without a field.
    """
    if "field_velocity" not in run:
        return {}
    density, level = np.asarray(run["field_density"]), np.asarray(run["level"])
    moved = np.nansum(np.asarray(run["field_velocity"]) * density, axis=-1)
    beads = np.nansum(density, axis=-1)
    return {
        "column_velocity": np.divide(moved, beads, out=np.full_like(beads, nan), where=beads > 0),
        "column_density": beads * float(level[1] - level[0]),
        "column": np.asarray(run["column"]),
    }


def cycle_means(run: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return forces on the belt and contact time against its phase, averaged over the window.

    Returns
    -------
    dict
        ``cycle_normal_force`` and ``cycle_shear_force`` (N), and ``cycle_contact_time``, each over
        (replicate, moment). ``cycle_phase`` (moment,) is the phase of the belt (rad) in the middle
        of each averaging interval. Empty for a run that has not recorded these series.
    """
    if "belt_normal_force" not in run:
        return {}
    number = int(run["samples_per_cycle"])
    moment = np.round(np.asarray(run["belt_phase"]) / (2 * pi) * number) % number
    start = np.asarray(run["average_start"])[:, None]
    profiles = {}
    for name, series in OVER_CYCLE.items():
        values = np.asarray(run[series])
        is_counted = (np.asarray(run["time"]) > start) & np.isfinite(values)
        profiles[name] = np.full((len(values), number), nan)
        for k in range(number):
            is_at_moment = is_counted & (moment == k)
            np.divide(
                np.where(is_at_moment, values, 0.0).sum(axis=1),
                is_at_moment.sum(axis=1),
                out=profiles[name][:, k],
                where=is_at_moment.any(axis=1),
            )
    # A sample is the mean over the interval that ends with it; the middle is half a sample earlier.
    return profiles | {"cycle_phase": (np.arange(number) - 0.5) * 2 * pi / number}
