"""Velocities of a dataset in natural units, and its parameters in SI units."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from sim.dataset.combine import join_declarations, point_coordinate
from sim.parameters import in_si
from sim.study.load import Point

_VELOCITIES = ("velocity", "velocity_half_width", "point_velocity", "point_half_width")


def natural_velocities(root: xr.Dataset) -> xr.Dataset:
    """Return the velocities of the root group in units of √(g · diameter) of each point."""
    velocity_unit = np.sqrt(root["gravity"] * root["diameter"])
    velocities = {
        name: (root[name] / velocity_unit).assign_attrs(
            units="1",
            long_name=root[name].attrs["long_name"],
            comment="multiple of √(gσ), of a belt √(g⟨d⟩)",
        )
        for name in _VELOCITIES
    }
    return xr.Dataset(velocities).reset_coords(drop=True)[list(velocities)]


def si_parameters(points: Sequence[Point]) -> xr.Dataset:
    """Return the dimensional parameters over ``point`` in SI, NaN where a point has none."""
    values_in_si = [in_si(point.parameters) for point in points]
    names = dict.fromkeys(name for row in values_in_si for name in row)
    systems = list(dict.fromkeys(point.parameters.system for point in points))
    variables = {}
    for name in names:
        (unit,) = {row[name].unit for row in values_in_si if name in row}
        values = [row[name].value if name in row else np.nan for row in values_in_si]
        attrs = {"units": unit, "long_name": join_declarations(name, "description", systems)}
        variables[name] = ("point", np.array(values, float), attrs)
    return xr.Dataset(variables, {"point": point_coordinate(points)})
