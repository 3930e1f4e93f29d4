"""How well the energy of one replicate of a run file adds up."""

import xarray as xr

MEASURES = {
    "missing_energy": ("1", "share of the energy turned over, gains included, that is not found")
}


def measure(run: xr.Dataset) -> dict[str, float]:
    """Return the share of the energy turned over that the ledger of a replicate lacks.

    A run file tells it relative to what was dissipated. Flows that accelerate, most of all those
    without friction, turn over more: what they gain counts too, from the means over the window.
    """
    if "energy_residual" not in run:
        return {}
    lacking = abs(float(run["energy_residual"]))
    if "frictional_power" not in run:
        return {"missing_energy": lacking}
    lost = float(run["frictional_power"] + run["normal_power"])
    mass = float(run["particles"] * run["mass"])
    gained = mass * float(run["velocity"] * run["acceleration"])
    return {"missing_energy": lacking * (lost / (lost + gained) if gained > 0 else 1.0)}
