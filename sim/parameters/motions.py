"""Motions of the belt of plug-ins, and the parameters of a belt with them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sim.base.additions import add
from sim.parameters.belt import BeltParameters
from sim.parameters.choices import WithOwn, extended, own, require_free

#: Kind of these additions, and the parameter that names them.
MOTION = "motion"

#: The motion of Talus: harmonic.
MOTIONS = ("harmonic",)


@dataclass(frozen=True)
class OwnMotion:
    """A motion of a plug-in: see `motion`."""

    make: Callable[[Any], Any]
    state: Callable[..., Any]
    parameters: Mapping[str, Any]


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
    own_parameters = dict(parameters or {})
    require_free(BeltParameters, f"motion {name}", own_parameters)
    add(MOTION, name, OwnMotion(make, state, own_parameters), MOTIONS)


def own_motions() -> dict[str, OwnMotion]:
    """Return the motions of plug-ins, by the names that points have for them."""
    return own(MOTION)


class _WithOwnMotions(WithOwn, BeltParameters):
    choice: ClassVar[str] = MOTION


def with_own_motions() -> Any:
    """Return the parameters of a belt that may have the motions of the plug-ins there are."""
    return extended(BeltParameters, _WithOwnMotions, MOTION, MOTIONS, "physics")
