"""The two systems: parameters -> particles, law, boundary, integrator and what to observe."""

from sim.engine.observe.system import System
from sim.parameters import BeltParameters, Parameters


def build(parameters: Parameters, replicate: int, substeps: int = 1) -> System:
    """Return replicate number ``replicate`` (from 0) of a point in its initial state.

    Every time step is divided into so many ``substeps``; samples are taken at the same times.
    """
    if isinstance(parameters, BeltParameters):
        from sim.engine.systems.belt import Belt

        return Belt(parameters, replicate, substeps)
    from sim.engine.systems.chute import Chute

    return Chute(parameters, replicate, substeps)
