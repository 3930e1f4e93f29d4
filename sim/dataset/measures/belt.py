"""Measures of the beads on a vibrating belt, from one replicate of a run file.

A run file holds series over ``time``, a field over ``column`` and ``level`` in the laboratory, and
the path of the beads over the cycle after the run.
"""

from collections.abc import Mapping
from math import atan2, nan, pi
from typing import Any

import numpy as np

from sim.dataset.run_file import NamedValues

#: Cycles after the start in which density waves are reported to be strongest.
EARLY_CYCLES = 10

#: Distance (⟨d⟩) from an obstacle beyond which its effect is no longer local.
FAR_DISTANCE = 5


def speed_along_x(belt: NamedValues) -> Any:
    """Return the amplitude of the belt's velocity along x, A_x 2πf (m/s), for one point or many."""
    amplitude = belt["amplitude"] * belt["diameter"] / np.tan(np.radians(belt["vibration_angle"]))
    return amplitude * 2 * pi * belt["frequency"]


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    values: dict[str, float] = {}
    if "base_occupancy" in run:
        values |= _series_measures(run)
    if "belt_normal_force" in run:
        values |= _force_measures(run)
    if "path" in run:
        path, diameter = np.asarray(run["path"]), float(run["diameter"])
        values |= path_measures(path)
        values["path_vertical_far"] = far_height(path, float(run["width"]) * diameter, diameter)
    if "field_velocity" in run:
        velocity, density = np.asarray(run["field_velocity"]), np.asarray(run["field_density"])
        values["backflow"] = backflow(velocity, density)
    return values


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


def _series_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return means of series over the averaging window and over the first cycles."""
    time, power = np.asarray(run["time"]), np.asarray(run["wave_power"])
    window = (time > float(run["average_start"])) & np.isfinite(power)
    early = time < (EARLY_CYCLES + 0.5 / int(run["samples_per_cycle"])) / float(run["frequency"])
    starts = window & is_at_phase_0(np.asarray(run["belt_phase"]), int(run["samples_per_cycle"]))
    occupancy = np.asarray(run["base_occupancy"])
    return {
        "base_occupancy": float(occupancy[window].mean()),
        "base_occupancy_at_phase_0": float(occupancy[starts].mean()) if starts.any() else nan,
        "wave_power": float(power[window].mean()),
        "wave_power_at_phase_0": float(power[starts].mean()) if starts.any() else nan,
        "early_wave_power": float(power[early].mean()),
    }


def _force_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the contact time and the phase of the force on the belt, over the averaging window.

    A sample is the mean over the interval that ends with it; the middle is half a sample earlier.
    """
    force, touched = np.asarray(run["belt_normal_force"]), np.asarray(run["belt_contact_time"])
    window = (np.asarray(run["time"]) > float(run["average_start"])) & np.isfinite(force)
    phase = np.asarray(run["belt_phase"])[window] - pi / int(run["samples_per_cycle"])
    centre = np.angle((force[window] * np.exp(1j * phase)).sum()) % (2 * pi)
    return {
        "belt_contact_time": float(touched[window].mean()) if window.any() else nan,
        "belt_force_phase": float(centre) if window.any() else nan,
    }


def is_at_phase_0(phase: np.ndarray, samples_per_cycle: int) -> np.ndarray:
    """True for samples that are nearest to the start of a cycle, by the belt's phase (rad)."""
    samples = np.round(phase / (2 * pi) * samples_per_cycle)
    return samples % samples_per_cycle == 0


def path_measures(path: np.ndarray) -> dict[str, float]:
    """Return the measures of a path (S, N, 2) in m over one whole cycle, both ends included.

    The last state is the first of the next cycle. It is used for the drift only.
    """
    drift = (path[-1] - path[0]).mean(axis=0)
    cycle = path[:-1]
    share = np.linspace(0.0, 1.0, len(path))[:-1, None]
    mean = cycle.mean(axis=1) - share * drift
    squares, axes = np.linalg.eigh(np.cov(mean.T, bias=True))
    minor, major = np.sqrt(np.clip(squares, 0.0, None))
    return {
        "path_drift": float(drift[0]),
        "path_vertical": _vertical_rms(cycle),
        "path_major": float(major),
        "path_minor": float(minor),
        "path_tilt": float(atan2(axes[1, 1], axes[0, 1]) % pi),
    }


def _vertical_rms(cycle: np.ndarray) -> float:
    """Return the rms vertical distance (m) of beads (S, N, 2) from their mean positions."""
    vertical = cycle[..., 1] - cycle[..., 1].mean(axis=0)
    return float(np.sqrt((vertical**2).mean()))


def far_height(path: np.ndarray, width: float, diameter: float) -> float:
    """Return the rms height (m) of the paths of beads far from the middle of the belt.

    The mean position of a bead over the cycle decides whether it is far. NaN where no bead is.

    Parameters
    ----------
    path : (S, N, 2) array
        Positions in m, as for `path_measures`; not folded into the cell.
    width, diameter : float
        Length of the belt and mean diameter, m.
    """
    cycle = path[:-1]
    distance = np.abs(cycle[..., 0].mean(axis=0) % width - 0.5 * width)
    far = distance > FAR_DISTANCE * diameter
    return _vertical_rms(cycle[:, far]) if far.any() else nan


def backflow(velocity: np.ndarray, density: np.ndarray) -> float:
    """Return the share of beads in squares whose mean velocity along x is negative."""
    return float(density[velocity < 0].sum() / density.sum())
