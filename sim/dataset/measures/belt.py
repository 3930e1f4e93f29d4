"""Measures of the beads on a vibrating belt, from one replicate of a run file.

A run file holds series over ``time``, a field over ``column`` and ``level`` in the laboratory, and
the path of the beads over the cycle that follows.
"""

from collections.abc import Mapping
from math import atan2, nan, pi
from typing import Any

import numpy as np

from sim.base.named import Named

#: Cycles after the start in which density waves are said to be strongest.
EARLY_CYCLES = 10

#: Distance (⟨d⟩) from an obstacle beyond which its effect is no longer local.
FAR = 5


def speed_along_x(belt: Named) -> Any:
    """Return the amplitude of the belt's velocity along x, A_x 2πf (m/s), of one point or many."""
    amplitude = belt["amplitude"] * belt["diameter"] / np.tan(np.radians(belt["vibration_angle"]))
    return amplitude * 2 * pi * belt["frequency"]


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    found: dict[str, float] = {}
    if "base_occupancy" in run:
        found |= _of_series(run)
    if "belt_normal_force" in run:
        found |= _of_forces(run)
    if "path" in run:
        path, diameter = np.asarray(run["path"]), float(run["diameter"])
        found |= path_measures(path)
        found["path_vertical_far"] = far_height(path, float(run["width"]) * diameter, diameter)
    if "field_velocity" in run:
        velocity, density = np.asarray(run["field_velocity"]), np.asarray(run["field_density"])
        found["backflow"] = backflow(velocity, density)
    return found


#: Means over the cycle of the vibration, by the time series that they are means of.
OVER_CYCLE = {
    "cycle_normal_force": "belt_normal_force",
    "cycle_shear_force": "belt_shear_force",
    "cycle_contact_time": "belt_contact_time",
}


def columns(run: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return velocity and density along the belt, means over all levels of the field.

    Returns
    -------
    dict
        ``column_velocity`` (m/s) and ``column_density`` (beads per length, m⁻¹), each over
        (replicate, square), and ``column`` (square), the centres of the squares along the belt (m);
        nothing for a run without a field.
    """
    if "field_velocity" not in run:
        return {}
    density, level = np.asarray(run["field_density"]), np.asarray(run["level"])
    carried = np.nansum(np.asarray(run["field_velocity"]) * density, axis=-1)
    beads = np.nansum(density, axis=-1)
    return {
        "column_velocity": np.divide(carried, beads, out=np.full_like(beads, nan), where=beads > 0),
        "column_density": beads * float(level[1] - level[0]),
        "column": np.asarray(run["column"]),
    }


def over_cycle(run: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return forces on the belt and contact time against its phase, means over the window.

    Returns
    -------
    dict
        ``cycle_normal_force`` and ``cycle_shear_force`` (N), and ``cycle_contact_time``, each over
        (replicate, moment), and ``cycle_phase`` (moment,), the phase of the belt (rad) in the
        middle of the intervals that they are means of; nothing for a run that has not kept them.
    """
    if "belt_normal_force" not in run:
        return {}
    number = int(run["samples_per_cycle"])
    moment = np.round(np.asarray(run["belt_phase"]) / (2 * pi) * number) % number
    start = np.asarray(run["average_start"])[:, None]
    found = {}
    for name, series in OVER_CYCLE.items():
        values = np.asarray(run[series])
        counted = (np.asarray(run["time"]) > start) & np.isfinite(values)
        found[name] = np.full((len(values), number), nan)
        for k in range(number):
            held = counted & (moment == k)
            np.divide(
                np.where(held, values, 0.0).sum(axis=1),
                held.sum(axis=1),
                out=found[name][:, k],
                where=held.any(axis=1),
            )
    # A sample stands for the interval that it ends, whose middle is half a sample before it.
    return found | {"cycle_phase": (np.arange(number) - 0.5) * 2 * pi / number}


def _of_series(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return means over the averaging window, and over the first cycles."""
    time, power = np.asarray(run["time"]), np.asarray(run["wave_power"])
    window = (time > float(run["average_start"])) & np.isfinite(power)
    early = time < (EARLY_CYCLES + 0.5 / int(run["samples_per_cycle"])) / float(run["frequency"])
    starts = window & at_phase_0(np.asarray(run["belt_phase"]), int(run["samples_per_cycle"]))
    occupancy = np.asarray(run["base_occupancy"])
    return {
        "base_occupancy": float(occupancy[window].mean()),
        "base_occupancy_at_phase_0": float(occupancy[starts].mean()) if starts.any() else nan,
        "wave_power": float(power[window].mean()),
        "wave_power_at_phase_0": float(power[starts].mean()) if starts.any() else nan,
        "early_wave_power": float(power[early].mean()),
    }


def _of_forces(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return when in the cycle the belt is touched and pressed, over the averaging window.

    A sample stands for the interval that it ends, whose middle is half a sample before it.
    """
    force, touched = np.asarray(run["belt_normal_force"]), np.asarray(run["belt_contact_time"])
    window = (np.asarray(run["time"]) > float(run["average_start"])) & np.isfinite(force)
    phase = np.asarray(run["belt_phase"])[window] - pi / int(run["samples_per_cycle"])
    centre = np.angle((force[window] * np.exp(1j * phase)).sum()) % (2 * pi)
    return {
        "belt_contact_time": float(touched[window].mean()) if window.any() else nan,
        "belt_force_phase": float(centre) if window.any() else nan,
    }


def at_phase_0(phase: np.ndarray, samples_per_cycle: int) -> np.ndarray:
    """Return which samples are nearest to the beginning of a cycle, by the belt's phase (rad)."""
    samples = np.round(phase / (2 * pi) * samples_per_cycle)
    return samples % samples_per_cycle == 0


def path_measures(path: np.ndarray) -> dict[str, float]:
    """Return the measures of a path (S, N, 2) in m over one whole cycle, both ends included.

    The last state is the first one of the next cycle: it tells the drift and counts for nothing
    else.
    """
    drift = (path[-1] - path[0]).mean(axis=0)
    cycle = path[:-1]
    share = np.linspace(0.0, 1.0, len(path))[:-1, None]
    mean = cycle.mean(axis=1) - share * drift
    squares, axes = np.linalg.eigh(np.cov(mean.T, bias=True))
    minor, major = np.sqrt(np.clip(squares, 0.0, None))
    return {
        "path_drift": float(drift[0]),
        "path_vertical": _height(cycle),
        "path_major": float(major),
        "path_minor": float(minor),
        "path_tilt": float(atan2(axes[1, 1], axes[0, 1]) % pi),
    }


def _height(cycle: np.ndarray) -> float:
    """Return the rms vertical distance (m) of beads (S, N, 2) from their mean places."""
    vertical = cycle[..., 1] - cycle[..., 1].mean(axis=0)
    return float(np.sqrt((vertical**2).mean()))


def far_height(path: np.ndarray, width: float, diameter: float) -> float:
    """Return the height (m) of the paths (S, N, 2) in m of beads far from the middle of the belt.

    What counts is the mean place of a bead in the cycle. NaN where no bead is that far away.

    Parameters
    ----------
    path : (S, N, 2) array
        As for `path_measures`; not folded into the cell.
    width, diameter : float
        Length of the belt and mean diameter, m.
    """
    cycle = path[:-1]
    distance = np.abs(cycle[..., 0].mean(axis=0) % width - 0.5 * width)
    far = distance > FAR * diameter
    return _height(cycle[:, far]) if far.any() else nan


def backflow(velocity: np.ndarray, density: np.ndarray) -> float:
    """Return the share of beads in squares whose mean velocity along x is negative."""
    return float(density[velocity < 0].sum() / density.sum())
