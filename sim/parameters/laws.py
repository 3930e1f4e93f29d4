"""Contact laws of plug-ins, and the parameters of a chute with them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, get_args

from sim.base.additions import add, blamed
from sim.parameters.choices import WithOwn, extended, named, own, require_free
from sim.parameters.chute import ChuteParameters

#: Kind of these additions, and the parameter that names them.
LAW = "law"

#: The laws of Talus.
LAWS: tuple[str, ...] = get_args(ChuteParameters.model_fields[LAW].annotation)


@dataclass(frozen=True)
class OwnLaw:
    """A contact law of a plug-in: see `law`."""

    make: Callable[[Any, Any], Any]
    force: Callable[..., Any]
    energy: Callable[..., Any]
    collision_time: Callable[[Any], float]
    parameters: Mapping[str, Any]


def law(
    name: str,
    *,
    make: Callable[[Any, Any], Any],
    force: Callable[..., Any],
    energy: Callable[..., Any],
    collision_time: Callable[[Any], float],
    parameters: Mapping[str, Any] | None = None,
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
        numbers (N); 4 numbers to remember; and the energy (J) that the normal force has dissipated
        in the step. ``overlap`` is in m, ``approach`` what it has grown by and ``slip`` the 3
        numbers by which the second surface has moved along the first in the step (m);
        ``tangential`` and ``memory`` are those of the last step, all zero for a new contact, the
        force turned with the contact; ``radius`` (m) and ``mass`` (kg) are the reduced ones.
    energy : callable
        ``energy(law, overlap, tangential, memory, radius, mass)``, compiled, returns the energy (J)
        in the normal and in the tangential spring.
    collision_time : callable
        ``collision_time(p)`` returns the time (s) of the shortest collision, of which a time step
        is one in ``steps_per_collision``.
    parameters : mapping, optional
        Parameters that it adds to those of the chute, made by `parameter`.
    """
    own_parameters = dict(parameters or {})
    require_free(ChuteParameters, f"law {name}", own_parameters)
    add(LAW, name, OwnLaw(make, force, energy, collision_time, own_parameters), LAWS)


def own_laws() -> dict[str, OwnLaw]:
    """Return the laws of plug-ins, by the names that points have for them."""
    return own(LAW)


def is_own(law: str) -> bool:
    """Return whether the law of a point is that of a plug-in, be it loaded or not."""
    return law not in (*LAWS, "")


class _WithOwnLaws(WithOwn, ChuteParameters):
    choice: ClassVar[str] = LAW

    @property
    def collision_time(self) -> float:
        """Duration of the shortest collision, s."""
        one = self.offered.get(self.law)
        if one is None:
            return super().collision_time
        with blamed(LAW, named(self.law)):
            time = float(one.collision_time(self))
            if not 0 < time < math.inf:
                raise ValueError(f"a collision takes {time} s")
        return time

    @property
    def caveat(self) -> str:
        """Say nothing of the start: how much spheres overlap is the law's affair."""
        return "" if self.law in self.offered else super().caveat


def with_own_laws() -> Any:
    """Return the parameters of a chute that may have the laws of the plug-ins there are."""
    return extended(ChuteParameters, _WithOwnLaws, LAW, LAWS, "reading")
