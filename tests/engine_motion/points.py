"""Whole systems in motion."""

import numpy as np

from sim.engine.systems import build, replica
from sim.parameters import Parameters, parse_point


def chute_point(**values) -> Parameters:
    """Parameters of the chute, changed."""
    return parse_point({"system": "chute", **values}, "test")


def belt_point(**values) -> Parameters:
    """Parameters of the belt, changed."""
    return parse_point({"system": "belt", **values}, "test")


def sums_of(system) -> tuple:
    """What the profiles of the next sample add."""
    profiles = system.sample(1, profiles=True).profiles
    return tuple(type(several)(*(part[0] for part in several)) for several in profiles)


def series_of(parameters: Parameters, replicate: int = 0) -> dict[str, np.ndarray]:
    """Time series (T,) of one replicate, transient and average."""
    system = build(parameters, replicate)
    system.settle()
    total = parameters.transient_samples + parameters.average_samples
    samples = [system.advance() for _ in range(total)]
    return {name: np.array([sample[name] for sample in samples]) for name in system.series}


def energy_residual(series: dict[str, np.ndarray], ledger) -> float:
    """What a ledger lacks after the first sample, relative to the energy turned over."""
    total = sum(sign * series[name] for name, sign in ledger.terms.items())
    turnover = sum(series[name][-1] - series[name][0] for name in ledger.turnover)
    return float((total[-1] - total[0]) / turnover)


def pause_within_samples(monkeypatch, point: Parameters) -> None:
    """Let a state be offered three times in each sample, of which a run else takes several in one
    go."""
    monkeypatch.setattr(replica, "MOST_WORK", point.particles * point.sample_steps // 3 + 1)
