"""An observable: how fast the spheres at the plane are, relative to the flow as a whole."""

import numpy as np

import talus


@talus.observable(
    "base_slip",
    system="chute",
    unit="1",
    meaning="velocity of the lowest diameter over the mean velocity",
)
def base_slip(run):
    height, packing = run["height"], run["packing_profile"]
    low = (height < run["diameter"]) & (packing > 0)
    if not low.any():
        return np.nan
    return np.average(run["velocity_profile"][low], weights=packing[low]) / run["velocity"]
