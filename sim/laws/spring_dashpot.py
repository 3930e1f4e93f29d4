"""Linear spring and dashpot: the compiled body is `sim.engine.contact.spring_dashpot`."""

from typing import Any, NamedTuple

from sim.parameters.dashpot import contact_time
from sim.parameters.laws import SMALL_OVERLAP, law
from sim.parameters.spheres import SphereParameters


def make(p: SphereParameters, partners: Any) -> NamedTuple:
    """Return the law of a point for one kind of partners."""
    from sim.engine.contact.spring_dashpot import spring_dashpot

    return spring_dashpot(
        p.stiffness,
        p.restitution,
        partners.friction,
        partners.reduced_mass,
        partners.time_step,
        p.tangential_ratio,
        p.attraction,
    )


def collision_time(p: SphereParameters) -> float:
    """Return the time for which the lightest particles push, s.

    π √(m*/K) √(1 + (ln e/π)²) where they also pull, less where that is clipped.
    """
    return 2 * p.loading_time * contact_time(p.restitution, p.attraction)


law(
    "spring_dashpot",
    description="a linear spring and dashpot with a linear tangential spring, as in most DEM "
    "codes; Cundall and Strack, 1979",
    make=make,
    force=None,
    energy=None,
    collision_time=collision_time,
    remembers=1,
    max_overlap=SMALL_OVERLAP,
    # The damping for a given restitution depends on the masses of the two partners.
    one_mass=True,
    owns=("attraction",),
)
