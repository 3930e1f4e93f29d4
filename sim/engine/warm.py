"""Compile the engine before a fan-out, so that no two runs compile the same code side by side."""

from collections.abc import Iterable

from sim.engine.systems import build
from sim.parameters import Parameters
from sim.parameters.roles import compiled


def variants(points: Iterable[Parameters]) -> list[Parameters]:
    """Return one small, short point per set of compiled kernels that the points need."""
    small: dict[tuple, Parameters] = {}
    for point in points:
        model = type(point)
        chosen = {name: getattr(point, name) for name in compiled(model)}
        small[(model, *chosen.values())] = model(**model.smallest, **chosen)
    return list(small.values())


def warm(points: Iterable[Parameters]) -> None:
    """Compile everything that runs of these points will call, and keep it in the cache folder."""
    for point in variants(points):
        system = build(point, 0)
        system.settle()
        system.advance()
        system.profiles(system.sample_profiles())
