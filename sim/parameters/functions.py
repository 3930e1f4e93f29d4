"""Points of a plug-in's plain function, which stands in place of a flow."""

from dataclasses import replace
from inspect import signature
from math import nan
from typing import Any, ClassVar, Literal

from pydantic import Field

from sim.base.additions import plugin_options
from sim.parameters.choices import Choice, Option
from sim.parameters.common import STEP_WORK, Parameters
from sim.parameters.roles import rows_of

#: The system, and the parameter that names the function.
NAME = "function"

row = rows_of(NAME)

#: Argument of a function that depends on chance: a generator of its own for each replicate.
RNG = "rng"


class FunctionParameters(Parameters):
    """A point of a function: no flow, but the same ids, run files, datasets and questions."""

    is_flow: ClassVar[bool] = False
    sampling_key: ClassVar[str] = NAME
    boundaries: ClassVar[tuple[str, ...]] = ()
    smallest_values: ClassVar[dict[str, Any]] = {}
    state_numbers: ClassVar[int] = 0
    axes: ClassVar[int] = 0
    most_contacts: ClassVar[int] = 0

    # A function has neither particles nor a length: these are no parameters of it.
    start_from: ClassVar[str] = ""  # type: ignore[misc]
    trajectory_contacts: ClassVar[bool] = False  # type: ignore[misc]
    target: ClassVar[float] = nan  # type: ignore[misc]
    diameter: ClassVar[float] = nan  # type: ignore[misc]
    mass: ClassVar[float] = nan  # type: ignore[misc]
    gravity: ClassVar[float] = nan  # type: ignore[misc]
    stiffness: ClassVar[float] = nan  # type: ignore[misc]
    transient: ClassVar[float] = 0.0  # type: ignore[misc]
    average: ClassVar[float] = 1.0  # type: ignore[misc]
    limit: ClassVar[float] = 1.0  # type: ignore[misc]
    trajectory: ClassVar[float] = 0.0  # type: ignore[misc]
    time_unit: ClassVar[float] = 1.0  # type: ignore[misc]
    time_step: ClassVar[float] = 1.0  # type: ignore[misc]
    sample_steps: ClassVar[int] = 1  # type: ignore[misc]
    particles: ClassVar[int] = 0  # type: ignore[misc]
    period: ClassVar[float] = 1.0  # type: ignore[misc]

    system: Literal["function"] = row("system")
    function: str = row("function")
    protocol: Literal["published"] = rows_of("all")("protocol")

    @property
    def rate(self) -> float:
        """Particle-steps per second that make a call, a step of no particle, take its time."""
        return STEP_WORK / self.option(NAME).seconds

    def require_rules(self) -> None:
        super().require_rules()
        if not self.option(NAME).is_random:
            for name in ("replicates", "seed"):
                self.require_default(name, f"the function has an argument {RNG}")


#: The choice of a function.
FUNCTION = replace(Choice.declared(NAME, FunctionParameters), shares=True)


class Function(Option):
    """A function: see `sim.parameters.observables.function`. ``make`` is the function itself."""

    returns: tuple[str, ...] = Field(min_length=1)
    seconds: float = Field(gt=0)

    @property
    def is_random(self) -> bool:
        """Whether it depends on chance."""
        return RNG in signature(self.make).parameters


def is_exact(name: str) -> bool:
    """Return whether the function of a point, by its name there, does not depend on chance."""
    option = plugin_options(NAME).get(name)
    return option is not None and not option.is_random
