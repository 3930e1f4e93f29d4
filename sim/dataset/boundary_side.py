"""The side of a boundary between regimes that a run is on."""

from collections.abc import Mapping
from pathlib import Path
from typing import cast

import numpy as np

from sim.base.seals import checked_read
from sim.dataset.run_file import NamedValues, summary_of
from sim.parameters import BeltParameters, ConveyorParameters, Parameters, amounts, point_id
from sim.parameters.belt import ONSET_TRANSPORT

#: Systems that can have a boundary of ``transport``.
VibratedParameters = BeltParameters | ConveyorParameters

#: Side of a boundary by regime, for each kind of boundary that regimes decide.
REGIME_SIDES = {
    "flow": {"arrested": "arrested", "steady": "flowing", "accelerating": "flowing"},
    "acceleration": {
        "arrested": "not accelerating",
        "steady": "not accelerating",
        "accelerating": "accelerating",
    },
}


#: The scalars of a run that decide its side.
SCALARS = (
    "status",
    "regime",
    "velocity",
    "velocity_half_width",
    "acceleration",
    "acceleration_half_width",
)


def side_of_run(path: Path, of: str, parameters: Parameters) -> str | None:
    """Return the side that the run in a file is on, see `side`.

    Raises
    ------
    InputError
        When there is no such file, or it is not a run file of this point.
    """
    with checked_read(path, "run file", replaceable=True, sealed=True):
        run = summary_of(path, amounts(parameters))
        if run.attrs["point_id"] != point_id(parameters):
            raise ValueError(f"holds point {run.attrs['point_id']}")
        return side(run.scalars, of, parameters)


def side(scalars: NamedValues, of: str, parameters: Parameters) -> str | None:
    """Return the side that a run is on, ``None`` where it is undecided.

    Failed replicates are left out; the others must agree. A flow of undetermined regime counts as
    flowing if the whole 95 % interval of its velocity is above zero and that of its acceleration
    is not wholly below zero.

    Parameters
    ----------
    scalars : mapping
        `SCALARS` of the run, each over its replicates.
    of : str
        What changes at the boundary: ``flow``, ``acceleration`` or ``transport``.
    parameters : Parameters
        The point.
    """
    values = {name: np.asarray(scalars[name]) for name in SCALARS}
    slowest, fastest = _interval_ends(values, "velocity")
    _, gain = _interval_ends(values, "acceleration")
    completed = np.flatnonzero(values["status"] == "completed")
    if of == "transport":
        # Only vibrated systems can have this boundary in a study.
        vibrated = cast(VibratedParameters, parameters)
        sides = {_transport_side(vibrated, slowest[index], fastest[index]) for index in completed}
    else:
        moving = (slowest > 0) & (gain >= 0)
        sides = {_regime_side(of, values["regime"][index], moving[index]) for index in completed}
    return sides.pop() if len(sides) == 1 else None


def _interval_ends(scalars: Mapping[str, np.ndarray], name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper ends of the 95 % intervals of a quantity, per replicate."""
    middle, half_width = scalars[name], scalars[f"{name}_half_width"]
    return middle - half_width, middle + half_width


def _regime_side(of: str, regime: str, moving: bool) -> str | None:
    """Return the side that a regime is on; an undetermined flow that moves is flowing."""
    if of == "flow" and regime == "undetermined" and moving:
        return "flowing"
    return REGIME_SIDES[of].get(regime)


def _transport_side(parameters: VibratedParameters, slowest: float, fastest: float) -> str | None:
    """Return the side that the whole 95 % interval of a mean velocity (m/s) is on."""
    least = ONSET_TRANSPORT * parameters.velocity_amplitude
    if fastest <= least:
        return "no transport"
    return "transport" if slowest > least else None
