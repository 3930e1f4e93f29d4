"""Contact laws: what a law is, and the call that adds one."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sim.base.require import require_count, require_positive, require_switch
from sim.parameters.choices import Choice, Option
from sim.parameters.chute import ChuteParameters
from sim.parameters.conveyor import ConveyorParameters
from sim.parameters.spheres import SMALL_OVERLAP

__all__ = ["LAW", "SMALL_OVERLAP", "Law", "law"]

#: The choice of a contact law.
LAW = Choice.declared("law", ChuteParameters, ConveyorParameters)


@dataclass(frozen=True)
class Law(Option):
    """A contact law: see `law`."""

    force: Callable[..., Any] | None
    energy: Callable[..., Any] | None
    collision_time: Callable[[Any], float]
    remembers: int
    one_mass: bool
    max_overlap: float
    variants: Mapping[type, tuple[Callable[..., Any], int]]

    argument_counts: ClassVar[Mapping[str, int]] = {
        "make": 2,
        "force": 8,
        "energy": 6,
        "collision_time": 1,
    }

    @property
    def compiled_by_hand(self) -> tuple[str, ...]:
        """Force and energy, where both are missing."""
        return ("force", "energy") if self.force is self.energy is None else ()

    def of(self, kind: type) -> tuple[Callable[..., Any] | None, int]:
        """Return the force of a type that ``make`` gives, and how many numbers it remembers."""
        return self.variants.get(kind, (self.force, self.remembers))


#: Numbers of its own that a law remembers of a contact unless it says another number, and at most.
USUALLY_REMEMBERED, MOST_REMEMBERED = 4, 32


def law(
    name: str,
    *,
    description: str = "",
    make: Callable[[Any, Any], Any],
    force: Callable[..., Any] | None,
    energy: Callable[..., Any] | None,
    collision_time: Callable[[Any], float],
    parameters: Mapping[str, Any] | None = None,
    remembers: int = USUALLY_REMEMBERED,
    one_mass: bool = False,
    max_overlap: float = math.inf,
    owns: tuple[str, ...] = (),
    variants: Mapping[type, tuple[Callable[..., Any], int]] | None = None,
) -> None:
    """Declare a contact law of the spheres, an option of the parameter ``law``.

    Parameters
    ----------
    name : str
        What points call it.
    description : str
        What it is, in a few words for the reference of parameters, with its source. A law that
        ships has one.
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
    one_mass : bool
        Whether the law needs particles of one mass: ``force`` makes no use of ``mass``.
    max_overlap : float
        Largest overlap of an impact, in diameters, for which the law stands. Faster starts get a
        caveat; the overlap is that of a spring of the stiffness K1.
    owns : tuple of str
        Parameters of Talus that have an effect with this law alone, or with others that own them,
        too: under all others they are refused.
    variants : mapping
        Types of what ``make`` returns that have another ``force``, with it and how many numbers
        that gives to remember. It may call ``force``.
    """
    require_count(f"law {name}: remembers", remembers, MOST_REMEMBERED)
    require_switch(f"law {name}: one_mass", one_mass)
    require_positive(f"law {name}: max_overlap", max_overlap)
    numbers = int(remembers), one_mass, float(max_overlap)
    option = description, make, parameters or {}, owns
    functions = force, energy, collision_time
    LAW.add(name, Law(*option, *functions, *numbers, dict(variants or {})))
