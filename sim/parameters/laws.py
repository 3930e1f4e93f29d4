"""Contact laws of plug-ins, and the parameters of a chute with them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, get_args

from sim.base.additions import attribute_errors_to
from sim.base.require import require_count
from sim.parameters.choices import Choice, OwnOption, WithOwn, named
from sim.parameters.chute import ChuteParameters
from sim.parameters.conveyor import ConveyorParameters
from sim.parameters.spheres import SphereParameters

#: The choice of a contact law.
LAW = Choice(
    "law",
    (ChuteParameters, ConveyorParameters),
    get_args(SphereParameters.model_fields["law"].annotation),
    "reading",
    kept=True,
)


@dataclass(frozen=True)
class OwnLaw(OwnOption):
    """A contact law of a plug-in: see `law`."""

    force: Callable[..., Any]
    energy: Callable[..., Any]
    collision_time: Callable[[Any], float]
    remembers: int

    takes: ClassVar[Mapping[str, int]] = {"make": 2, "force": 8, "energy": 6, "collision_time": 1}


#: Numbers of its own that a law remembers of a contact unless it says another number, and at most.
USUALLY_REMEMBERED, MOST_REMEMBERED = 4, 32


def law(
    name: str,
    *,
    make: Callable[[Any, Any], Any],
    force: Callable[..., Any],
    energy: Callable[..., Any],
    collision_time: Callable[[Any], float],
    parameters: Mapping[str, Any] | None = None,
    remembers: int = USUALLY_REMEMBERED,
) -> None:
    """Declare a contact law of the spheres, an option of the parameter ``law``.

    Parameters
    ----------
    name : str
        What points call it.
    make : callable
        ``make(p, partners)`` returns a ``NamedTuple`` of numbers, which the next two get as
        ``law``: from the parameters of the point and the ``friction``, mean ``reduced_mass`` (kg)
        and ``time_step`` (s) of one kind of partners, two spheres or a sphere and the plane.
    force : callable
        ``force(law, overlap, approach, slip, tangential, memory, radius, mass)``, compiled, returns
        the normal force (N), positive where it repels; the tangential one on the first partner, 3
        numbers (N); a tuple of the numbers to remember; and the energy (J) that the normal force
        has dissipated in the step. ``overlap`` is in m, ``approach`` what it has grown by and
        ``slip`` the 3 numbers by which the second surface has moved along the first in the step
        (m); ``tangential`` and ``memory`` are those of the last step, all zero for a new contact,
        the force turned with the contact; ``radius`` (m) and ``mass`` (kg) are the reduced ones.
    energy : callable
        ``energy(law, overlap, tangential, memory, radius, mass)``, compiled, returns the energy (J)
        in the normal and in the tangential spring.
    collision_time : callable
        ``collision_time(p)`` returns the time (s) of the shortest collision, of which a time step
        is one in ``steps_per_collision``.
    parameters : mapping, optional
        Parameters that it adds to those of the chute, made by `parameter`.
    remembers : int
        How many numbers ``force`` gives to remember.
    """
    require_count(f"law {name}: remembers", remembers, MOST_REMEMBERED)
    LAW.add(name, OwnLaw(make, parameters or {}, force, energy, collision_time, int(remembers)))


class WithOwnLaws(WithOwn, SphereParameters):
    """What a law of a plug-in says of a system of spheres."""

    @property
    def collision_time(self) -> float:
        """Duration of the shortest collision, s."""
        one = self.own_option(LAW)
        if one is None:
            return super().collision_time
        with attribute_errors_to(LAW.name, named(self.law)):
            time = float(one.collision_time(self))
            if not 0 < time < math.inf:
                raise ValueError(f"a collision takes {time} s")
        return time

    @property
    def caveat(self) -> str:
        """Say nothing of the start: how much spheres overlap is the law's affair."""
        return "" if self.own_option(LAW) else super().caveat


class ChuteWithOwn(WithOwnLaws, ChuteParameters):
    """Parameters of a chute with laws of plug-ins."""
