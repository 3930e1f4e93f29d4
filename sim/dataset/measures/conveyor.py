"""Measures of flows on a vibrating plane, from one replicate of a run file."""

from collections.abc import Mapping
from math import pi
from typing import Any

from sim.dataset.measures.chute import base_measures, overlap_measures


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    amplitude = float(run["amplitude_along"]) * float(run["diameter"]) * 2 * pi * run["frequency"]
    values = {"shaking_strength": float(run["plane_acceleration"] / run["gravity"])}
    if amplitude:
        values["transport_efficiency"] = float(run["velocity"]) / amplitude
    return values | overlap_measures(run) | base_measures(run)
