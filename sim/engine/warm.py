"""Compile the engine before many runs start, so that no two compile the same code in parallel."""

from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from sim.engine.systems import build
from sim.parameters import Parameters
from sim.parameters.roles import compiled_parameters


def variants(points: Iterable[Parameters]) -> list[Parameters]:
    """Return one small, short point per set of compiled kernels that the points need."""
    small: dict[tuple, Parameters] = {}
    for point in points:
        model = type(point)
        choices = {name: getattr(point, name) for name in compiled_parameters(model)}
        small[(model, *choices.values())] = model(**model.smallest_values, **choices)
    return list(small.values())


def warm(points: Iterable[Parameters], processes: int = 1) -> None:
    """Compile everything that runs of these points will call, and store it in the cache folder.

    Systems share little code: with several ``processes`` they are compiled in parallel.
    """
    systems: dict[type, list[Parameters]] = {}
    for point in variants(points):
        systems.setdefault(type(point), []).append(point)
    if processes == 1 or len(systems) == 1:
        for group in systems.values():
            _compile(group)
        return
    with ProcessPoolExecutor(processes, get_context("fork")) as pool:
        list(pool.map(_compile, systems.values()))


def _compile(points: Iterable[Parameters]) -> None:
    for point in points:
        system = build(point, 0)
        system.settle()
        system.sample(1, profiles=True)
