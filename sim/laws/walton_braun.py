"""Walton and Braun's law: its compiled body is `sim.engine.contact.walton_braun`."""

from typing import Any, NamedTuple

from sim.parameters.laws import SMALL_OVERLAP, law
from sim.parameters.spheres import SphereParameters


def make(p: SphereParameters, partners: Any) -> NamedTuple:
    """Return the law of a point for one kind of partners."""
    from sim.engine.contact.walton_braun import walton_braun

    return walton_braun(
        p.stiffness,
        p.restitution,
        partners.friction,
        p.tangential_ratio,
        p.tangential_exponent,
        overlap_memory=p.overlap_memory,
        friction_cap=p.friction_cap,
        sliding_direction=p.sliding_direction,
    )


def collision_time(p: SphereParameters) -> float:
    """Return t_c = (π/2) √(m*/K1) (1 + e) of the lightest particles, s."""
    return p.loading_time * (1 + p.restitution)


law(
    "walton_braun",
    description="that of Walton and Braun, Walton, Sec. 2",
    make=make,
    force=None,
    energy=None,
    collision_time=collision_time,
    max_overlap=SMALL_OVERLAP,
)
