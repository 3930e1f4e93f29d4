"""Energy balance of one replicate of a run file: the share that its ledger lacks."""

from collections.abc import Mapping
from math import nan
from typing import Any

from sim.parameters.observables import observable
from sim.parameters.variables import ALL


@observable(
    "missing_energy",
    system=ALL,
    unit="1",
    meaning="share of the energy turned over, gains included, that is not found",
)
def missing_energy(run: Mapping[Any, Any]) -> float:
    """Return the share of the energy turned over that the ledger lacks, NaN without a ledger.

    A run file has the share relative to the dissipated energy, or to the net work of a belt. Flows
    that accelerate turn over more, most of all those that lose nothing: a rolling sphere. Here
    their gain of kinetic energy counts too, from the means over the window. Without
    ``frictional_power`` (belt) the residual is the share. It says nothing of a belt whose bed moves
    as a block, which takes up and gives back energy and loses next to none.
    """
    if "energy_residual" not in run:
        return nan
    lacking = abs(float(run["energy_residual"]))
    if "frictional_power" not in run:
        return lacking
    lost = float(run["frictional_power"]) + float(run["normal_power"])
    mass = float(run["particles"]) * float(run["mass"])
    gained = mass * float(run["velocity"]) * float(run["acceleration"])
    return lacking * (lost / (lost + gained) if gained > 0 else 1.0)
