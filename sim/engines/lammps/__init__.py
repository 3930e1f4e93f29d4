"""LAMMPS, a program of others: flows on a plane with the laws that both know.

`deck` says a point in its commands, `process` runs it, `replica` takes samples of it as of a flow
of our own.
"""

from collections.abc import Iterator
from typing import Any

from sim.parameters.dashpot import by_restitution
from sim.parameters.laws import flow_engine

#: Laws that it has: `deck` says how.
LAWS = ("spring_dashpot", "hertz", "drag")

#: Parameters that must have these values, as nothing in it corresponds to others.
FIXED = {
    "motion": "harmonic",
    "shape": "sphere",
    "stress_profiles": False,
    "trajectory_contacts": False,
    "start_from": "",
    "threads": 1,
}

#: Parameters that must be 0 with its drag, whose rates are those of one mass.
ONE_MASS = ("diameter_spread", "bumps")

#: Restitution of a clipped force at the critical damping, e⁻², rounded up.
LEAST_CLIPPED = 0.136

#: Variables that it does not tell: energies in and lost by contacts, what the moving plane does,
#: extremes within a sample, and how far spheres have turned.
LACKS = (
    *("stored_energy", "normal_loss", "frictional_loss", "energy_residual"),
    *("normal_power", "frictional_power", "plane_work", "plane_power", "tilt_power"),
    *("largest_overlap", "max_overlap", "orientation"),
)


def refuses(p: Any) -> Iterator[tuple[str, str]]:
    """Yield the parameters of a point that it cannot follow, with the values that it can."""
    if p.law not in LAWS:
        yield "law", f"{', '.join(LAWS[:-1])} or {LAWS[-1]}"
    for name, value in FIXED.items():
        if getattr(p, name, value) != value:
            yield name, str(value).lower() or "none"
    for name in ONE_MASS if p.law == "drag" else ():
        if getattr(p, name):
            yield name, "0 with law: drag"
    if p.law == "drag" and not p.has_one_mass:
        yield "initial_state", "particles of one mass with law: drag"
    if by_restitution(p) and p.attraction == "clipped" and p.restitution <= LEAST_CLIPPED:
        # It takes the damping as the restitution that it gives where it may pull.
        yield "restitution", f"above {LEAST_CLIPPED:g} with attraction: clipped and law: {p.law}"
    if by_restitution(p) and p.tangential_damping:
        yield "tangential_damping", "0 with several masses, unless normal_damping is given"
    if p.tangential_damping and p.restitution == 1:
        yield "restitution", "below 1 with tangential_damping"
    if p.law == "drag" and p.attraction != "kept":
        # Where the normal force is clipped it cuts the drag along surfaces to 0, too.
        yield "attraction", "kept with law: drag"
    if p.law == "drag" and p.restitution == 1:
        # It gives the drag along surfaces as a multiple of that along the normal.
        yield "restitution", "below 1 with law: drag"


def make(p: Any, replicate: int, substeps: int) -> Any:
    """Return a replicate of a point in its initial state, which is that of Talus to the bit."""
    from sim.engines.lammps.replica import REPLICAS

    return REPLICAS[p.system](p, replicate, substeps)


flow_engine(
    "lammps",
    description="LAMMPS, a program of others, on one process or several; docs/second_engine.md",
    make=make,
    refuses=refuses,
    lacks=LACKS,
    module="lammps",
    package="lammps[mpi]",
    speed=0.5,
    owns=("ranks",),
)
