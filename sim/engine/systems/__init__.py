"""The systems: parameters -> particles, law, boundary, integrator and observables."""

from importlib import import_module

from sim.engine.systems.replica import Replica
from sim.parameters import Parameters
from sim.parameters.laws import make_replica

#: Module and class of each system, imported only when needed with the kernels it compiles.
SYSTEMS = {
    "chute": ("chute", "Chute"),
    "belt": ("belt", "Belt"),
    "conveyor": ("conveyor", "Conveyor"),
}


def build(parameters: Parameters, replicate: int, substeps: int = 1) -> Replica:
    """Return replicate number ``replicate`` (from 0) of a point in its initial state.

    The engine of the point makes it. Every time step is divided into ``substeps``; samples are
    taken at the same times.
    """
    return make_replica(parameters, replicate, substeps)


def build_own(parameters: Parameters, replicate: int, substeps: int) -> Replica:
    """Return what `build` returns where this program is the engine."""
    module, name = SYSTEMS[parameters.system]
    system = getattr(import_module(f"{__name__}.{module}"), name)
    return system(parameters, replicate, substeps)
