"""Measures of flows on a vibrating plane, from one replicate of a run file."""

from collections.abc import Mapping
from math import pi
from typing import Any

from sim.dataset.measures.chute import of_base, of_overlaps


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    along = float(run["amplitude_along"]) * float(run["diameter"]) * 2 * pi * run["frequency"]
    found = {"shaking_strength": float(run["plane_acceleration"] / run["gravity"])}
    if along:
        found["transport_efficiency"] = float(run["velocity"]) / along
    return found | of_overlaps(run) | of_base(run)
