"""On which side of a boundary between regimes a run is."""

from collections.abc import Mapping
from pathlib import Path
from typing import cast

import numpy as np

from sim.base.damage import checked_read
from sim.base.named import Named
from sim.dataset.summary import summary_of
from sim.parameters import BeltParameters, ConveyorParameters, Parameters, amounts, point_id
from sim.parameters.belt import ONSET_TRANSPORT

#: Systems whose boundary of ``transport`` may be asked for.
Vibrated = BeltParameters | ConveyorParameters

#: Sides of the boundaries that regimes tell, by regime.
REGIMES = {
    "flow": {"arrested": "arrested", "steady": "flowing", "accelerating": "flowing"},
    "acceleration": {
        "arrested": "not accelerating",
        "steady": "not accelerating",
        "accelerating": "accelerating",
    },
}


#: The scalars of a run that say on which side it is.
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
        When there is no such file, or it cannot be read as a run.
    """
    with checked_read(path, "run file", replaceable=True, sealed=True):
        run = summary_of(path, amounts(parameters))
        if run.attrs["point_id"] != point_id(parameters):
            raise ValueError(f"holds point {run.attrs['point_id']}")
        return side(run.scalars, of, parameters)


def side(scalars: Named, of: str, parameters: Parameters) -> str | None:
    """Return the side that a run is on, ``None`` where it does not tell.

    Replicates that failed are left out; the others must agree. A flow whose trend is unknown flows
    if the whole 95 % interval of its velocity is above zero and it is not shown to slow down.

    Parameters
    ----------
    scalars : mapping
        `SCALARS` of the run, each over its replicates.
    of : str
        What changes at the boundary: ``flow``, ``acceleration`` or ``transport``.
    parameters : Parameters
        The point.
    """
    held = {name: np.asarray(scalars[name]) for name in SCALARS}
    slowest, fastest = _interval(held, "velocity")
    _, gain = _interval(held, "acceleration")
    done = np.flatnonzero(held["status"] == "completed")
    if of == "transport":
        # Studies ask for the transport of what vibrates alone.
        vibrated = cast(Vibrated, parameters)
        sides = {_transport(vibrated, slowest[index], fastest[index]) for index in done}
    else:
        moving = (slowest > 0) & (gain >= 0)
        sides = {_of_regime(of, held["regime"][index], moving[index]) for index in done}
    return sides.pop() if len(sides) == 1 else None


def _interval(scalars: Mapping[str, np.ndarray], name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the 95 % intervals of a quantity of all replicates."""
    middle, half_width = scalars[name], scalars[f"{name}_half_width"]
    return middle - half_width, middle + half_width


def _of_regime(of: str, regime: str, moving: bool) -> str | None:
    """Return the side that a regime is on; an undetermined one flows if it is surely moving."""
    if of == "flow" and regime == "undetermined" and moving:
        return "flowing"
    return REGIMES[of].get(regime)


def _transport(parameters: Vibrated, slowest: float, fastest: float) -> str | None:
    """Return the side that the whole 95 % interval of a mean velocity (m/s) is on."""
    least = ONSET_TRANSPORT * parameters.velocity_amplitude
    if fastest <= least:
        return "no transport"
    return "transport" if slowest > least else None
