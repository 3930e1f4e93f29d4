"""Measures of the beads on a vibrating belt, from one replicate of a run file.

A run file holds series over ``time``, a field over ``column`` and ``level`` in the laboratory, and
the path of the beads over the cycle that follows.
"""

from math import atan2, nan, pi
from typing import Any

import numpy as np
import xarray as xr

from sim.base.named import Named

MEASURES = {
    "base_occupancy": ("1", "share of beads with centres within A_z of the mean belt position"),
    "wave_power": ("1", "power of the five longest density waves, relative to beads at random"),
    "early_wave_power": ("1", "the same over the first 10 cycles"),
    "path_drift": ("m", "mean displacement of the beads along the belt in a cycle"),
    "path_vertical": ("m", "rms vertical distance of the beads from their mean places in a cycle"),
    "path_vertical_far": (
        "m",
        "the same of beads more than 5 ⟨d⟩ along the belt from its middle, where obstacles stand",
    ),
    "path_major": ("m", "rms extent of the mean path, less its drift, along its long axis"),
    "path_minor": ("m", "rms extent of the mean path, less its drift, along its short axis"),
    "path_tilt": ("rad", "angle of the long axis of the mean path with the horizontal, 0 to π"),
    "backflow": (
        "1",
        "share of beads in squares of the laboratory whose mean velocity is negative",
    ),
}

#: Share of the beads within A_z of the mean belt position below which there is a void.
EMPTY = 0.02

#: Cycles after the start in which density waves are said to be strongest.
EARLY_CYCLES = 10

#: Distance (⟨d⟩) from an obstacle beyond which its effect is no longer local.
FAR = 5


def speed_along_x(belt: Named) -> Any:
    """Return the amplitude of the belt's velocity along x, A_x 2πf (m/s), of one point or many."""
    amplitude = belt["amplitude"] * belt["diameter"] / np.tan(np.radians(belt["vibration_angle"]))
    return amplitude * 2 * pi * belt["frequency"]


def measure(run: xr.Dataset) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    found: dict[str, float] = {}
    if "base_occupancy" in run:
        found |= _of_series(run)
    if "path" in run:
        path, diameter = run["path"].values, run["diameter"].item()
        found |= path_measures(path)
        found["path_vertical_far"] = far_height(path, run["width"].item() * diameter, diameter)
    if "field_velocity" in run:
        found["backflow"] = backflow(run["field_velocity"].values, run["field_density"].values)
    return found


def columns(run: xr.Dataset) -> xr.Dataset:
    """Return velocity and density along the belt, means over all levels of the field.

    Returns
    -------
    xarray.Dataset
        ``column_velocity`` (m/s) and ``column_density`` (beads per length, m⁻¹), each over
        (replicate, square), and ``column`` (square), the centres of the squares along the belt (m);
        empty for a run without a field.
    """
    if "field_velocity" not in run:
        return xr.Dataset()
    density = run["field_density"]
    carried = (run["field_velocity"] * density).sum("level")
    beads = density.sum("level")
    height = float(run["level"][1] - run["level"][0])
    found = xr.Dataset(
        {
            "column_velocity": (carried / beads.where(beads > 0)).assign_attrs(
                units="m s-1", long_name="mean velocity along the belt of the beads in a column"
            ),
            "column_density": (beads * height).assign_attrs(
                units="m-1", long_name="number of beads per length of the belt"
            ),
        }
    )
    return found.reset_index("column").reset_coords("column").rename_dims(column="square")


def _of_series(run: xr.Dataset) -> dict[str, float]:
    """Return means over the averaging window, and over the first cycles."""
    time, power = run["time"].values, run["wave_power"].values
    window = (time > run["average_start"].item()) & np.isfinite(power)
    early = time < (EARLY_CYCLES + 0.5 / run["samples_per_cycle"].item()) / run["frequency"].item()
    return {
        "base_occupancy": float(run["base_occupancy"].values[window].mean()),
        "wave_power": float(power[window].mean()),
        "early_wave_power": float(power[early].mean()),
    }


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
