"""Motions of plug-ins, and the parameters of a belt and of a conveyor with them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from pydantic import model_validator

from sim.parameters.belt import BeltParameters
from sim.parameters.choices import Choice, OwnOption, WithOwn, require_usual
from sim.parameters.conveyor import ConveyorParameters
from sim.parameters.laws import WithOwnLaws

#: The choice of a motion; that of Talus is harmonic.
MOTION = Choice(
    "motion", (BeltParameters, ConveyorParameters), ("harmonic",), "physics", kept=False
)

#: What of the plane's motion a motion of a plug-in takes the place of.
_HARMONIC = (
    "phase_along",
    "overtone",
    "overtone_amplitude",
    "overtone_along",
    "overtone_phase",
)


@dataclass(frozen=True)
class OwnMotion(OwnOption):
    """A motion of a plug-in: see `motion`."""

    state: Callable[..., Any]

    takes: ClassVar[Mapping[str, int]] = {"make": 1, "state": 2}


def motion(
    name: str,
    *,
    make: Callable[[Any], Any],
    state: Callable[..., Any],
    parameters: Mapping[str, Any] | None = None,
) -> None:
    """Declare a motion of the belt and of the plane of the conveyor.

    It is an option of their parameter ``motion``, which is ``harmonic``.

    Parameters
    ----------
    name : str
        What points call it.
    make : callable
        ``make(p)`` returns a ``NamedTuple`` of numbers from the parameters of the point.
    state : callable
        ``state(motion, angle)``, compiled, returns how high the base is, in amplitudes A_z, and the
        derivatives of x, in A_x, and of z after the ``angle`` (rad), with whose period 2π it
        repeats: sin, cos, cos of the harmonic motion. The angle is ωt + φ of a belt and ωt of a
        conveyor. Where the base is along x makes no difference.
    parameters : mapping, optional
        Parameters that it adds to those of belt and conveyor, made by `parameter`.
    """
    MOTION.add(name, OwnMotion(make, parameters or {}, state))


class BeltWithOwn(WithOwn, BeltParameters):
    """Parameters of a belt with motions of plug-ins."""


class ConveyorWithOwn(WithOwnLaws, ConveyorParameters):
    """Parameters of a conveyor with laws and motions of plug-ins."""

    @model_validator(mode="after")
    def _of_harmonic_motions_alone(self) -> Self:
        for name in _HARMONIC if self.own_option(MOTION) else ():
            require_usual(self, name, "motion is harmonic, whose it is")
        return self
