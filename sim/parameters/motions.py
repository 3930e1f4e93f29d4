"""Motions of belt and plane: what a motion is, and the call that adds one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sim.base.plugins import module_names
from sim.parameters.belt import BeltParameters
from sim.parameters.choices import Choice, Option
from sim.parameters.common import CHOICES
from sim.parameters.conveyor import ConveyorParameters

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
