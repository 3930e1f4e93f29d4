"""Measures of the beads on a vibrating belt, from one replicate of a run file."""

import xarray as xr

MEASURES = {
    "base_occupancy": ("1", "share of beads with centres within A_z of the mean belt position"),
}


def measure(run: xr.Dataset) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    if "base_occupancy" not in run:
        return {}
    window = run["time"].values > run["average_start"].item()
    return {"base_occupancy": float(run["base_occupancy"].values[window].mean())}
