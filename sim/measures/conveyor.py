"""Measures of flows on a vibrating plane, from one replicate of a run file."""

from collections.abc import Mapping
from math import nan, pi
from typing import Any

from sim.parameters.observables import observable


@observable(
    "shaking_strength",
    system="conveyor",
    unit="1",
    meaning="peak acceleration of the plane along z over gravity, A_z ω²/g",
)
def shaking_strength(run: Mapping[Any, Any]) -> float:
    """Return the peak acceleration of the plane along z over gravity."""
    return float(run["plane_acceleration"] / run["gravity"])


@observable(
    "transport_efficiency",
    system="conveyor",
    unit="1",
    meaning="mean velocity over that of the plane along x, V/(A_x ω)",
)
def transport_efficiency(run: Mapping[Any, Any]) -> float:
    """Return the mean velocity over the plane's amplitude of velocity, NaN if it moves up alone."""
    amplitude = float(run["amplitude_along"]) * float(run["diameter"]) * 2 * pi * run["frequency"]
    return float(run["velocity"]) / amplitude if amplitude else nan
