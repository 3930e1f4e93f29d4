"""Measures of the beads on a vibrating belt, from one replicate of a run file.

A run file holds series over ``time``, a field over ``column`` and ``level`` in the laboratory, and
the path of the beads over the cycle after the run.
"""

from collections.abc import Mapping
from math import atan2, nan, pi
from typing import Any

import numpy as np

from sim.parameters.observables import declare_observables, form, observable

#: Cycles after the start in which density waves are reported to be strongest.
EARLY_CYCLES = 10

#: Distance (⟨d⟩) from an obstacle beyond which its effect is no longer local.
FAR_DISTANCE = 5


def series_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return means of series over the averaging window and over the first cycles."""
    if "base_occupancy" not in run:
        return {}
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


declare_observables(
    series_measures,
    {
        "base_occupancy": ("1", "share of beads with centres within A_z of the mean belt position"),
        "base_occupancy_at_phase_0": ("1", "the same at the beginning of the cycle alone"),
        "wave_power": ("1", "power of the five longest density waves, relative to beads at random"),
        "wave_power_at_phase_0": ("1", "the same at the beginning of the cycle alone"),
        "early_wave_power": ("1", "the same at all times of the first 10 cycles"),
    },
    system="belt",
)


def force_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the contact time and the phase of the force on the belt, over the averaging window.

    A sample is the mean over the interval that ends with it; the middle is half a sample earlier.
    """
    if "belt_normal_force" not in run:
        return {}
    force, touched = np.asarray(run["belt_normal_force"]), np.asarray(run["belt_contact_time"])
    window = (np.asarray(run["time"]) > float(run["average_start"])) & np.isfinite(force)
    phase = np.asarray(run["belt_phase"])[window] - pi / int(run["samples_per_cycle"])
    centre = np.angle((force[window] * np.exp(1j * phase)).sum()) % (2 * pi)
    return {
        "belt_contact_time": float(touched[window].mean()) if window.any() else nan,
        "belt_force_phase": float(centre) if window.any() else nan,
    }


declare_observables(
    force_measures,
    {
        "belt_contact_time": ("1", "share of the time in which any bead touches the belt"),
        "belt_force_phase": ("rad", "phase of the belt about which the force on it lies, 0 to 2π"),
    },
    system="belt",
    asked_by="belt_forces",
)


def is_at_phase_0(phase: np.ndarray, samples_per_cycle: int) -> np.ndarray:
    """True for samples that are nearest to the start of a cycle, by the belt's phase (rad)."""
    samples = np.round(phase / (2 * pi) * samples_per_cycle)
    return samples % samples_per_cycle == 0


def path_measures(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the measures of the path (S, N, 2) in m over one whole cycle, both ends included.

    The last state is the first of the next cycle. It is used for the drift only.
    """
    if "path" not in run:
        return {}
    path = np.asarray(run["path"])
    drift = (path[-1] - path[0]).mean(axis=0)
    cycle = path[:-1]
    share = np.linspace(0.0, 1.0, len(path))[:-1, None]
    mean = cycle.mean(axis=1) - share * drift
    squares, axes = np.linalg.eigh(np.cov(mean.T, bias=True))
    minor, major = np.sqrt(np.clip(squares, 0.0, None))
    return {
        "path_drift": float(drift[0]),
        "path_vertical": _vertical_rms(cycle),
        "path_vertical_far": _far_height(cycle, run),
        "path_major": float(major),
        "path_minor": float(minor),
        "path_tilt": float(atan2(axes[1, 1], axes[0, 1]) % pi),
    }


def _vertical_rms(cycle: np.ndarray) -> float:
    """Return the rms vertical distance (m) of beads (S, N, 2) from their mean positions."""
    vertical = cycle[..., 1] - cycle[..., 1].mean(axis=0)
    return float(np.sqrt((vertical**2).mean()))


def _far_height(cycle: np.ndarray, run: Mapping[Any, Any]) -> float:
    """Return the rms height (m) of the paths (S, N, 2) of beads far from the middle of the belt.

    The mean position of a bead over the cycle, folded into the cell, decides whether it is far.
    NaN where no bead is.
    """
    diameter, width = float(run["diameter"]), float(run["width"]) * float(run["diameter"])
    distance = np.abs(cycle[..., 0].mean(axis=0) % width - 0.5 * width)
    far = distance > FAR_DISTANCE * diameter
    return _vertical_rms(cycle[:, far]) if far.any() else nan


declare_observables(
    path_measures,
    {
        "path_drift": ("m", "mean displacement of the beads along the belt in a cycle"),
        "path_vertical": (
            "m",
            "rms vertical distance of the beads from their mean places in a cycle",
        ),
        "path_vertical_far": (
            "m",
            "the same of beads more than 5 ⟨d⟩ along the belt from its middle, where obstacles "
            "stand",
        ),
        "path_major": ("m", "rms extent of the mean path, less its drift, along its long axis"),
        "path_minor": ("m", "rms extent of the mean path, less its drift, along its short axis"),
        "path_tilt": ("rad", "angle of the long axis of the mean path with the horizontal, 0 to π"),
    },
    system="belt",
)


@observable(
    "backflow",
    system="belt",
    unit="1",
    meaning="share of beads in squares of the laboratory whose mean velocity is negative",
)
def backflow(run: Mapping[Any, Any]) -> float:
    """Return the share of beads in squares whose mean velocity along x is negative."""
    if "field_velocity" not in run:
        return nan
    velocity, density = np.asarray(run["field_velocity"]), np.asarray(run["field_density"])
    return float(density[velocity < 0].sum() / density.sum())


def speed_along_x(belt: Any) -> Any:
    """Return the amplitude of the belt's velocity along x, A_x 2πf (m/s), for one point or many."""
    amplitude = belt["amplitude"] * belt["diameter"] / np.tan(np.radians(belt["vibration_angle"]))
    return amplitude * 2 * pi * belt["frequency"]


def acceleration_share(belt: Any) -> Any:
    """Return the belt's peak acceleration along z over gravity, for one point or many."""
    along_z = belt["amplitude"] * belt["diameter"] * (2 * pi * belt["frequency"]) ** 2
    return along_z / belt["gravity"]


def _log_frequency(belt: Any) -> Any:
    return np.log(belt["frequency"])


def _rest(belt: Any) -> Any:
    """Return the share of gravity at which beads do not leave the belt: 1 below its onset."""
    return 1 / np.maximum(acceleration_share(belt), 1.0)


# The belt carries its bed along, and beads that do not leave it go nowhere.
form(
    "logarithmic",
    system="belt",
    observable="velocity",
    meaning="over the logarithm of the frequency",
    inputs={"frequency": _log_frequency},
)
form(
    "efficiency",
    system="belt",
    observable="velocity",
    meaning="as a share of the belt's velocity A_x ω",
    scale=speed_along_x,
)
form(
    "efficiency_of_shaking",
    system="belt",
    observable="velocity",
    meaning="as a share of the belt's velocity A_x ω, "
    "over the logarithm of the frequency and 1/max(Γ, 1)",
    scale=speed_along_x,
    inputs={"frequency": _log_frequency, "rest": _rest},
)
