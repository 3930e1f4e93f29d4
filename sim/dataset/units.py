"""What a dataset has in other units beside: velocities in natural ones, parameters in SI."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from sim.dataset.combine import declared, ids
from sim.parameters import in_si
from sim.study.load import Point

_VELOCITIES = ("velocity", "velocity_half_width", "point_velocity", "point_half_width")


def in_natural_units(found: xr.Dataset) -> xr.Dataset:
    """Return the velocities of the root of a dataset in √(g diameter) of their points."""
    velocity_unit = np.sqrt(found["gravity"] * found["diameter"])
    made = {
        name: (found[name] / velocity_unit).assign_attrs(
            units="1",
            long_name=found[name].attrs["long_name"],
            comment="multiple of √(gσ), of a belt √(g⟨d⟩)",
        )
        for name in _VELOCITIES
    }
    return xr.Dataset(made).reset_coords(drop=True)[list(made)]


def in_si_units(points: Sequence[Point]) -> xr.Dataset:
    """Return the parameters that have a dimension over ``point``, NaN where a point has none."""
    given = [in_si(point.parameters) for point in points]
    names = dict.fromkeys(name for one in given for name in one)
    systems = list(dict.fromkeys(point.parameters.system for point in points))
    held = {}
    for name in names:
        (unit,) = {one[name].unit for one in given if name in one}
        values = [one[name].value if name in one else np.nan for one in given]
        attrs = {"units": unit, "long_name": declared(name, "description", systems)}
        held[name] = ("point", np.array(values, float), attrs)
    return xr.Dataset(held, {"point": ids(points)})
