"""Contact laws: what a law is, and the call that adds one."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, ClassVar

from sim.base.additions import attribute_errors_to, plain_name
from sim.base.errors import InputError
from sim.base.plugins import (
    module_names,
    require_count,
    require_line,
    require_names,
    require_positive,
    require_switch,
)
from sim.parameters.belt import BeltParameters
from sim.parameters.choices import Choice, Option
from sim.parameters.chute import ChuteParameters
from sim.parameters.common import CHOICES
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


#: The choice of an engine.
ENGINE = Choice.declared("engine", ChuteParameters, ConveyorParameters)


@dataclass(frozen=True)
class Engine(Option):
    """An engine: see `flow_engine`."""

    refuses: Callable[[Any], Iterable[tuple[str, str]]]
    lacks: tuple[str, ...]
    module: str
    package: str
    speed: float

    argument_counts: ClassVar[Mapping[str, int]] = {"make": 3, "refuses": 1}


def flow_engine(
    name: str,
    *,
    description: str = "",
    make: Callable[[Any, int, int], Any],
    refuses: Callable[[Any], Iterable[tuple[str, str]]] = lambda p: (),
    lacks: Iterable[str] = (),
    module: str = "",
    package: str = "",
    speed: float = 1.0,
    parameters: Mapping[str, Any] | None = None,
    owns: tuple[str, ...] = (),
) -> None:
    """Declare a program that computes flows on a plane, an option of the parameter ``engine``.

    Parameters
    ----------
    name : str
        What points call it.
    description : str
        What it is, in a few words for the reference of parameters. An engine that ships has one.
    make : callable
        ``make(p, replicate, substeps)`` returns a replicate of a point in its initial state, a
        `sim.engine.systems.replica.Replica`; every time step is divided into ``substeps``.
    refuses : callable, optional
        ``refuses(p)`` returns what the engine cannot do of a point: pairs of a parameter and of the
        values that it may have, in words.
    lacks : iterable of str
        Names of the variables that its run files do not have, as it cannot tell them.
    module, package : str
        Module of Python without which it does not run, and what ``pip install`` needs for it.
    speed : float
        Its particle-steps per second over those of Talus, about.
    parameters : mapping, optional
        Parameters that it adds to those of the systems, made by `parameter`.
    owns : tuple of str
        Parameters of Talus that have an effect with this engine alone.
    """
    lacks = tuple(lacks)
    require_names(f"engine {name}: lacks", lacks)
    require_line(f"engine {name}: module", module, empty=True)
    require_line(f"engine {name}: package", package, empty=not module)
    require_positive(f"engine {name}: speed", speed)
    option = description, make, parameters or {}, owns
    ENGINE.add(name, Engine(*option, refuses, lacks, module, package, float(speed)))


def engine_of(parameters: Any) -> Engine:
    """Return the engine of a point.

    Raises
    ------
    InputError
        Where the engine needs a package that is not installed.
    """
    option, name = parameters.option(ENGINE.name), getattr(parameters, ENGINE.name, "")
    if option.module and find_spec(option.module) is None:
        raise InputError(
            f"engine: {plain_name(name)}: needs a package that is not installed: "
            f"pip install '{option.package}'"
        )
    return option


def make_replica(parameters: Any, replicate: int, substeps: int) -> Any:
    """Return a replicate of a point by its engine; an error of a plug-in names the plug-in."""
    option = engine_of(parameters)
    with attribute_errors_to(ENGINE.name, plain_name(getattr(parameters, ENGINE.name, "talus"))):
        return option.make(parameters, replicate, substeps)


#: The choice of a motion.
MOTION = Choice(
    "motion",
    "motion of the base",
    (BeltParameters, ConveyorParameters),
    tuple(dict.fromkeys((CHOICES["motion"], *module_names("sim.laws.motions")))),
    "physics",
    kept=False,
)


@dataclass(frozen=True)
class Motion(Option):
    """A motion: see `motion`."""

    state: Callable[..., Any] | None

    argument_counts: ClassVar[Mapping[str, int]] = {"make": 1, "state": 2}

    @property
    def compiled_by_hand(self) -> tuple[str, ...]:
        """The function ``state``, where it is missing."""
        return () if self.state else ("state",)


def motion(
    name: str,
    *,
    description: str = "",
    make: Callable[[Any], Any],
    state: Callable[..., Any] | None,
    parameters: Mapping[str, Any] | None = None,
    owns: tuple[str, ...] = (),
) -> None:
    """Declare a motion of the belt and of the plane of the conveyor.

    It is an option of their parameter ``motion``, which is ``harmonic``.

    Parameters
    ----------
    name : str
        What points call it.
    description : str
        What it is, in a few words for the reference of parameters. A motion that ships has one.
    make : callable
        ``make(p)`` returns a ``NamedTuple`` of numbers from the parameters of the point.
    state : callable
        ``state(motion, angle)``, compiled, returns how high the base is, in amplitudes A_z, and the
        derivatives of x, in A_x, and of z after the ``angle`` (rad), with whose period 2π it
        repeats: sin, cos, cos of the harmonic motion. The angle is ωt + φ of a belt and ωt of a
        conveyor. Where the base is along x makes no difference.
    parameters : mapping, optional
        Parameters that it adds to those of belt and conveyor, made by `parameter`.
    owns : tuple of str
        Parameters of Talus that have an effect with it alone: under other motions they are refused.
    """
    MOTION.add(name, Motion(description, make, parameters or {}, owns, state))
