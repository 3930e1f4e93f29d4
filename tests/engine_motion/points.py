"""Whole systems in motion."""

import numpy as np

from sim.engine.systems import build
from sim.parameters import Parameters, parse_point


def chute_point(**values) -> Parameters:
    """Parameters of the chute, changed."""
    return parse_point({"system": "chute", **values}, "test")


def belt_point(**values) -> Parameters:
    """Parameters of the belt, changed."""
    return parse_point({"system": "belt", **values}, "test")


def series_of(parameters: Parameters, replicate: int = 0) -> dict[str, np.ndarray]:
    """Time series (T,) of one replicate, transient and average."""
    system = build(parameters, replicate)
    system.settle()
    total = parameters.transient_samples + parameters.average_samples
    samples = [system.advance() for _ in range(total)]
    return {name: np.array([sample[name] for sample in samples]) for name in system.series}
