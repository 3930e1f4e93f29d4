"""Motions of the belt of plug-ins, and the parameters of a belt with them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sim.parameters.belt import BeltParameters
from sim.parameters.choices import Choice, OwnOption, WithOwn

#: The choice of a motion; that of Talus is harmonic.
MOTION = Choice("motion", (BeltParameters,), ("harmonic",), "physics")


@dataclass(frozen=True)
class OwnMotion(OwnOption):
    """A motion of a plug-in: see `motion`."""

    state: Callable[..., Any]


def motion(
    name: str,
    *,
    make: Callable[[Any], Any],
    state: Callable[..., Any],
    parameters: Mapping[str, Any] | None = None,
) -> None:
    """Declare a motion of the belt, an option of the parameter ``motion``, which is ``harmonic``.

    Parameters
    ----------
    name : str
        What points call it.
    make : callable
        ``make(p)`` returns a ``NamedTuple`` of numbers from the parameters of the point.
    state : callable
        ``state(motion, angle)``, compiled, returns how high the belt is, in amplitudes A_z, and the
        derivatives of x, in A_x, and of z after the ``angle`` ωt + φ (rad), with whose period 2π it
        repeats: sin, cos, cos of the harmonic motion. Where it is along x makes no difference.
    parameters : mapping, optional
        Parameters that it adds to those of the belt, made by `parameter`.
    """
    MOTION.add(name, OwnMotion(make, parameters or {}, state))


class WithOwnMotions(WithOwn, BeltParameters):
    """Parameters of a belt with motions of plug-ins."""

    choice: ClassVar[Choice] = MOTION
