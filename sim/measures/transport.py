"""Measures of what vibration carries along: a belt's bed, a conveyor's flow."""

from collections.abc import Mapping
from math import cos, nan, pi, radians
from typing import Any

from sim.measures.belt import acceleration_share, speed_along_x
from sim.parameters.observables import observable


@observable(
    "shaking_strength",
    system=("belt", "conveyor"),
    unit="1",
    meaning="peak acceleration of the plane along z over gravity, A_z ω²/g",
)
def shaking_strength(run: Mapping[Any, Any]) -> float:
    """Return the peak acceleration of the plane along z over gravity."""
    if "plane_acceleration" not in run:
        return float(acceleration_share(run)) if "amplitude" in run else nan
    return float(run["plane_acceleration"] / run["gravity"])


@observable(
    "throw_number",
    system="conveyor",
    unit="1",
    meaning="peak acceleration normal to the plane over gravity's, A_z ω²/(g cos θ)",
)
def throw_number(run: Mapping[Any, Any]) -> float:
    """Return the shaking strength over the share of gravity that presses on the plane."""
    return shaking_strength(run) / cos(radians(run["angle"])) if "angle" in run else nan


@observable(
    "transport_efficiency",
    system=("belt", "conveyor"),
    unit="1",
    meaning="mean velocity over that of the plane along x, V/(A_x ω)",
)
def transport_efficiency(run: Mapping[Any, Any]) -> float:
    """Return the mean velocity over the plane's amplitude of velocity, NaN if it moves up alone."""
    if "amplitude" not in run:
        return nan
    if "amplitude_along" not in run:
        is_vertical = run["vibration_angle"] >= 90 or not run["amplitude"]
        return nan if is_vertical else float(run["velocity"] / speed_along_x(run))
    amplitude = float(run["amplitude_along"]) * float(run["diameter"]) * 2 * pi * run["frequency"]
    return float(run["velocity"]) / amplitude if amplitude else nan
