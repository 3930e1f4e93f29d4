"""On which side of a boundary between regimes a run is."""

from pathlib import Path

import netCDF4
import numpy as np

from sim.parameters import BeltParameters, Parameters, point_id
from sim.stored import reading

#: Sides of the boundaries that regimes tell, by regime; an undetermined one tells nothing.
REGIMES = {
    "flow": {"arrested": "arrested", "steady": "flowing", "accelerating": "flowing"},
    "acceleration": {
        "arrested": "not accelerating",
        "steady": "not accelerating",
        "accelerating": "accelerating",
    },
}


def side_of_run(path: Path, of: str, parameters: Parameters) -> str | None:
    """Return the side that a run is on, ``None`` where it does not tell.

    Replicates that failed are left out; the others must agree.

    Parameters
    ----------
    path : Path
        The run file.
    of : str
        What changes at the boundary: ``flow``, ``acceleration`` or ``transport``.
    parameters : Parameters
        The point.

    Raises
    ------
    InputError
        When there is no such file, or it cannot be read as a run.
    """
    with reading(path, "run file", replaceable=True), netCDF4.Dataset(path) as run:
        if run.point_id != point_id(parameters):
            raise ValueError(f"holds point {run.point_id}")
        run.set_auto_mask(False)
        status, regime = run["status"][:], run["regime"][:]
        velocity, half_width = run["velocity"][:], run["velocity_half_width"][:]
    done = np.flatnonzero(status == "completed")
    if of == "transport":
        sides = {_transport(parameters, velocity[index], half_width[index]) for index in done}
    else:
        sides = {REGIMES[of].get(regime[index]) for index in done}
    return sides.pop() if len(sides) == 1 else None


def _transport(parameters: BeltParameters, velocity: float, half_width: float) -> str | None:
    """Return the side that the whole 95 % interval of a mean velocity (m/s) is on."""
    least = parameters.least_transport
    if velocity + half_width <= least:
        return "no transport"
    return "transport" if velocity - half_width > least else None
