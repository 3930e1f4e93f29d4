"""Put profiles over the height above the belt on a grid of ⟨d⟩, from slices that may be thinner.

"With a grid size ⟨d⟩" (Gallas, Sec. 3) leaves open which beads count at which height. The grids:

``centres``
    cells [k, k + 1) ⟨d⟩, each value at the centre of its cell;
``edges``
    the same cells, each value at the lower edge;
``points``
    points k ⟨d⟩, each value from the beads nearest to the point; half a cell at the belt counts as
    a whole one;
``slices``
    the slices of the run file, unchanged.
"""

from collections.abc import Callable
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends import NetCDF4DataStore
from xarray.backends.common import ArrayWriter

from sim.parameters.variables import AT_PHASE_0

GRIDS = ("centres", "edges", "points", "slices")

#: Profiles that are sums over the beads in a slice; all others are means over these beads.
DENSITIES = ("number_density", "packing_profile")


def number_density_name(name: str) -> str:
    """Return the name of the number density at the same time as a profile."""
    return "number_density" + (AT_PHASE_0 if name.endswith(AT_PHASE_0) else "")


def regrid(
    grid: str,
    diameter: float,
    height: np.ndarray,
    name: str,
    values: np.ndarray,
    number: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return a profile on a grid (R, K) and its heights (K,) in m.

    Granular temperatures do not include the differences of mean velocity between slices of a cell.
    ``grid`` is one of `GRIDS`, ``diameter`` ⟨d⟩ (m), ``height`` (H,) the centres of the slices (m),
    ``values`` (R, H) the profile of this name and ``number`` (R, H) the number density of the
    beads. Without that, only densities can be put on another grid. Raises `ValueError` when the
    slices are too thick for the grid, or do not fill its cells.
    """
    share = diameter / (height[1] - height[0]) if height.size > 1 else 1.0
    slices = round(share)
    is_whole = abs(share - slices) < 1e-6 and slices > 0
    if grid == "slices" or (grid == "centres" and is_whole and slices == 1):
        return values, height
    if not is_whole or (grid == "points" and slices % 2):
        raise ValueError(f"is not known on the grid of {grid}: its slices are {1 / share:.3g} ⟨d⟩")
    shift = slices // 2 if grid == "points" else 0
    cells = (height.size + shift) // slices
    if name.startswith(DENSITIES):
        profile = _cells(values, shift, slices, cells) / slices
    elif number is None:
        raise ValueError("is not known on that grid: it needs the number density")
    else:
        profile = mean_over(values, number, lambda beads: _cells(beads, shift, slices, cells))
    offset = 0.5 if grid == "centres" else 0.0
    return profile, (np.arange(cells) + offset) * diameter


def mean_over(
    values: np.ndarray, weights: np.ndarray, total: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Return weighted means of the values that are finite, not-a-number where there are none.

    ``total`` returns the sums over what is averaged of an array like ``values``.
    """
    weight = np.where(np.isfinite(values), weights, 0.0)
    whole, sums = total(weight), total(np.nan_to_num(values) * weight)
    return np.divide(sums, whole, out=np.full_like(sums, np.nan), where=whole > 0)


def _cells(values: np.ndarray, shift: int, slices: int, cells: int) -> np.ndarray:
    """Return sums over cells of ``slices`` slices, after ``shift`` empty slices below the first."""
    padded = np.pad(values, ((0, 0), (shift, 0)))[:, : cells * slices]
    return padded.reshape(len(values), cells, slices).sum(axis=-1)


def open_group(file: netCDF4.Dataset, group: str | None) -> xr.Dataset:
    """Return a group of an open file, the root without a name; each access reads from the file."""
    return xr.open_dataset(NetCDF4DataStore(file[group] if group else file), cache=False)


class Values(ArrayWriter):
    """The values of variables that xarray has defined, written by `fill`.

    xarray writes the values of each variable before it defines the next. For the library below, a
    definition after values costs as much as all earlier definitions together.
    """

    def __init__(self) -> None:
        super().__init__()
        self._queue: list[tuple[Any, Any]] = []

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Queue the values of a variable; xarray calls this."""
        self._queue.append((source, target))

    def define(
        self, dataset: xr.Dataset, group: netCDF4.Dataset, encoding: dict[str, Any] | None = None
    ) -> None:
        """Define the variables and attributes of a dataset in an open file or a group of it."""
        dataset.dump_to_store(NetCDF4DataStore(group), writer=self, encoding=encoding or {})

    def fill(self) -> None:
        """Write the values of all variables that were defined since the last call."""
        for source, target in self._queue:
            target[...] = source
        self._queue.clear()
