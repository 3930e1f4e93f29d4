"""On which side of a boundary between regimes a run is."""

from pathlib import Path

import netCDF4
import numpy as np

from sim.base.reading import reading
from sim.parameters import BeltParameters, Parameters, point_id

#: Sides of the boundaries that regimes tell, by regime.
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

    Replicates that failed are left out; the others must agree. A flow whose trend is unknown flows
    if the whole 95 % interval of its velocity is above zero and it is not shown to slow down.

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
        slowest, fastest = _interval(run, "velocity")
        _, gain = _interval(run, "acceleration")
    done = np.flatnonzero(status == "completed")
    if of == "transport":
        sides = {_transport(parameters, slowest[index], fastest[index]) for index in done}
    else:
        moving = (slowest > 0) & (gain >= 0)
        sides = {_of_regime(of, regime[index], moving[index]) for index in done}
    return sides.pop() if len(sides) == 1 else None


def _interval(run: netCDF4.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the 95 % intervals of a quantity of all replicates."""
    middle, half_width = run[name][:], run[f"{name}_half_width"][:]
    return middle - half_width, middle + half_width


def _of_regime(of: str, regime: str, moving: bool) -> str | None:
    """Return the side that a regime is on; an undetermined one flows if it is surely moving."""
    if of == "flow" and regime == "undetermined" and moving:
        return "flowing"
    return REGIMES[of].get(regime)


def _transport(parameters: BeltParameters, slowest: float, fastest: float) -> str | None:
    """Return the side that the whole 95 % interval of a mean velocity (m/s) is on."""
    least = parameters.least_transport
    if fastest <= least:
        return "no transport"
    return "transport" if slowest > least else None
