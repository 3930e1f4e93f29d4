"""Compile the engine before a fan-out, so that no two runs compile the same code side by side."""

from collections.abc import Iterable

from sim.engine.systems import build
from sim.parameters import BeltParameters, ChuteParameters, Parameters

#: Parameters whose values choose what is compiled; all others only change numbers.
COMPILED = {
    "chute": ("law", "tangential_exponent", "overlap_memory", "friction_cap", "orientations"),
    "belt": ("damping_mass", "attraction", "integrator"),
}


def variants(points: Iterable[Parameters]) -> list[Parameters]:
    """Return one small, short point per set of compiled kernels that the points need."""
    small: dict[tuple, Parameters] = {}
    for point in points:
        chosen = {name: getattr(point, name) for name in COMPILED[point.system]}
        if point.system == "chute":
            tiny = ChuteParameters(depth=0.2, cell=5, **chosen)
        else:
            tiny = BeltParameters(beads=2, settle_velocity_squared=1e6, **chosen)
        small[(point.system, *chosen.values())] = tiny
    return list(small.values())


def warm(points: Iterable[Parameters]) -> None:
    """Compile everything that runs of these points will call, and keep it in the cache folder."""
    for point in variants(points):
        system = build(point, 0)
        system.settle()
        system.advance()
        system.profiles(system.sample_profiles())
