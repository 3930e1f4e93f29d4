"""Engines, the programs that compute a flow: what an engine is, and the call that adds one."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, ClassVar

from sim.base.additions import attribute_errors_to, plain_name
from sim.base.errors import InputError
from sim.base.require import require_line, require_names, require_positive
from sim.parameters.choices import Choice, Option
from sim.parameters.chute import ChuteParameters
from sim.parameters.conveyor import ConveyorParameters

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
