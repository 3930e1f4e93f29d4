"""Measures of flows on a vibrating plane, from one replicate of a run file."""

from collections.abc import Mapping
from math import pi
from typing import Any

from sim.dataset.measures.chute import of_base, of_overlaps


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    rate, diameter = 2 * pi * float(run["frequency"]), float(run["diameter"])
    along = float(run["amplitude_along"]) * diameter * rate
    normal = float(run["amplitude"]) * diameter * rate * rate
    found = {"shaking_strength": normal / float(run["gravity"])}
    if along:
        found["transport_efficiency"] = float(run["velocity"]) / along
    return found | of_overlaps(run) | of_base(run)
