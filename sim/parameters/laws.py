"""Laws, engines, motions and functions: what each is, and the calls that add them."""

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from importlib.util import find_spec
from inspect import signature
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from sim.base.additions import attribute_errors_to, plain_name
from sim.base.errors import InputError
from sim.base.plugins import Line, Names, module_names, takes
from sim.parameters.belt import BeltParameters
from sim.parameters.choices import Choice, Option
from sim.parameters.chute import ChuteParameters
from sim.parameters.common import CHOICES, STEP_WORK, Parameters, broken_rule
from sim.parameters.conveyor import ConveyorParameters
from sim.parameters.roles import rows_of
from sim.parameters.spheres import SMALL_OVERLAP

__all__ = ["LAW", "SMALL_OVERLAP", "Law", "law"]

#: The choice of a contact law.
LAW = Choice.declared("law", ChuteParameters, ConveyorParameters)

#: Numbers of its own that a law remembers of a contact unless it says another number, and at most.
USUALLY_REMEMBERED, MOST_REMEMBERED = 4, 32


class Law(Option):
    """A contact law: see `law`."""

    make: Annotated[Callable[..., Any], takes(2)]
    force: Annotated[Callable[..., Any], takes(8)] | None
    energy: Annotated[Callable[..., Any], takes(6)] | None
    collision_time: Annotated[Callable[[Any], float], takes(1)]
    reach: Annotated[Callable[[Any], float], takes(1)] = lambda p: 0.0
    rolls: bool = False
    remembers: int = Field(USUALLY_REMEMBERED, ge=0, le=MOST_REMEMBERED)
    one_mass: bool = False
    replaces: dict[str, Names] = {}
    ignores: Names = ()
    selects: Annotated[Callable[[Any], dict[str, float]], takes(1)] = lambda p: {}
    max_overlap: float = Field(math.inf, gt=0)
    turns: int = Field(0, ge=0)
    variants: dict[type, tuple[Callable[..., Any], int] | tuple[Callable[..., Any], int, int]] = {}

    def require_rules(self) -> None:
        for _, remembers, turns in map(self.of, (object, *self.variants)):
            if not 0 <= 3 * turns <= remembers:
                raise broken_rule("turns", turns, f"3 numbers each of the {remembers} remembered")
        if unknown := set(self.ignores) - ChuteParameters.model_fields.keys():
            raise broken_rule("ignores", min(unknown), "names of parameters of the chute")

    def of(self, kind: type) -> tuple[Callable[..., Any] | None, int, int]:
        """Return the force of a type that ``make`` gives, what it remembers and how much turns."""
        force, remembers, *turns = self.variants.get(kind, (self.force, self.remembers))
        return force, remembers, turns[0] if turns else self.turns

    def has_functions(self, kind: type) -> bool:
        """Return whether a type that ``make`` gives has a ``force``, or a body compiled by hand."""
        return self.of(kind)[0] is not None


class RollingLaw(Law):
    """A contact law whose functions know of rolling: see `law`."""

    force: Annotated[Callable[..., Any], takes(10)] | None
    energy: Annotated[Callable[..., Any], takes(7)] | None


def law(name: str, **fields: Any) -> None:
    """Declare a contact law of the spheres, an option of the parameter ``law``.

    Parameters
    ----------
    name : str
        What points call it.
    **fields
        The following, of which a plug-in's law needs the functions.
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
    turns : int
        How many vectors of 3 numbers come first among them: they turn with the contact as the
        tangential force does, and change sign with the order of the partners.
    rolls : bool
        Whether partners resist rolling and twisting. ``force`` gets ``rolling`` and ``torque``,
        too, and returns the torque on the first partner as a fifth value; ``energy`` gets
        ``torque``. Each has 4 numbers: 3 across the normal, and one about it, from the first
        partner to the second. ``rolling`` is the angle (rad) by which the second has turned
        relative to the first in the step; ``torque`` (N m) that of the last step, turned with the
        contact. Its work counts as that against friction.
    reach : callable
        ``reach(p)`` returns how far (m) beyond contact ``force`` is called, whose ``overlap`` is
        negative there.
    one_mass : bool
        Whether the law needs particles of one mass: ``force`` makes no use of ``mass``.
    max_overlap : float
        Largest overlap of an impact, in diameters, for which the law stands. Faster starts get a
        caveat; the overlap is that of a spring of the stiffness K1.
    owns : tuple of str
        Parameters of Talus that have an effect with this law alone, or with others that own them,
        too: under all others they are refused.
    replaces : mapping
        Parameters other than 0 stand in place of others, which then have their defaults: the name
        of each with the names of these.
    ignores : tuple of str
        Parameters of Talus without effect under the law, such as ``restitution``.
    selects : callable
        ``selects(p)`` returns those numbers that give a small point the type of a point, where
        ``make`` chooses it by others than the options.
    variants : mapping
        Types of what ``make`` returns that have another ``force``, with it, how many numbers
        that gives to remember and, where it differs, how many vectors turn. It may call ``force``.
    """
    LAW.add(name, RollingLaw if fields.get("rolls") is True else Law, **fields)


#: The choice of an engine.
ENGINE = Choice.declared("engine", ChuteParameters, ConveyorParameters)


class Engine(Option):
    """An engine: see `flow_engine`."""

    make: Annotated[Callable[..., Any], takes(3)]
    refuses: Annotated[Callable[[Any], Iterable[tuple[str, str]]], takes(1)] = lambda p: ()
    lacks: Annotated[Names, BeforeValidator(tuple)] = ()
    module: Line = ""
    package: Line = ""
    speed: float = Field(1.0, gt=0)


def flow_engine(name: str, **fields: Any) -> None:
    """Declare a program that computes flows on a plane, an option of the parameter ``engine``.

    Parameters
    ----------
    name : str
        What points call it.
    **fields
        The following, of which it needs ``make``.
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
    ENGINE.add(name, Engine, **fields)


def engine_of(parameters: Any) -> Engine:
    """Return the engine of a point.

    Raises `InputError` where the engine needs a package that is not installed.
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


class Motion(Option):
    """A motion: see `motion`."""

    make: Annotated[Callable[..., Any], takes(1)]
    state: Annotated[Callable[..., Any], takes(2)] | None


def motion(name: str, **fields: Any) -> None:
    """Declare a motion of the belt and of the plane of the conveyor.

    It is an option of their parameter ``motion``, which is ``harmonic``.

    Parameters
    ----------
    name : str
        What points call it.
    **fields
        The following, of which a plug-in's motion needs the functions.
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
    MOTION.add(name, Motion, **fields)


#: The system, and the parameter that names the function.
FUNCTION_NAME = "function"

#: Argument of a function that depends on chance: a generator of its own for each replicate.
RNG = "rng"


class FunctionParameters(Parameters):
    """A point of a function: no flow, but the same ids, run files, datasets and questions."""

    model_config = ConfigDict(ignored_types=(int, float))
    is_flow: ClassVar[bool] = False
    sampling_key: ClassVar[str] = FUNCTION_NAME
    boundaries: ClassVar[tuple[str, ...]] = ()
    in_place: ClassVar[dict[str, Any]] = {}
    smallest_values: ClassVar[dict[str, Any]] = {}
    state_numbers = axes = most_contacts = 0

    # A function has neither particles nor a length: these are no parameters of it.
    start_from: ClassVar[str] = ""  # type: ignore[misc]
    trajectory_contacts: ClassVar[bool] = False  # type: ignore[misc]
    target: ClassVar[float] = math.nan  # type: ignore[misc]
    diameter = mass = gravity = stiffness = math.nan  # type: ignore[pydantic-field]
    transient = trajectory = 0.0  # type: ignore[pydantic-field]
    average = limit = time_unit = time_step = period = 1.0  # type: ignore[pydantic-field]
    sample_steps, particles = 1, 0  # type: ignore[pydantic-field]

    system: Literal["function"] = rows_of(FUNCTION_NAME)("system")
    function: str = rows_of(FUNCTION_NAME)("function")
    protocol: Literal["published"] = rows_of("all")("protocol")

    @property
    def rate(self) -> float:
        """Particle-steps per second that make a call, a step of no particle, take its time."""
        return STEP_WORK / self.option(FUNCTION_NAME).seconds

    def require_rules(self) -> None:
        super().require_rules()
        if not self.option(FUNCTION_NAME).is_random:
            for name in ("replicates", "seed"):
                self.require_default(name, f"the function has an argument {RNG}")


#: The choice of a function.
FUNCTION = replace(Choice.declared(FUNCTION_NAME, FunctionParameters), shares=True)


class Function(Option):
    """A function: see `sim.parameters.observables.function`. ``make`` is the function itself."""

    returns: tuple[str, ...] = Field(min_length=1)
    seconds: float = Field(gt=0)

    @property
    def is_random(self) -> bool:
        """Whether it depends on chance."""
        return RNG in signature(self.make).parameters
