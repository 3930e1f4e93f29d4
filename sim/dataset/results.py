"""What a study has found, as figures and judges read it: its dataset with all groups."""

from dataclasses import dataclass, field
from pathlib import Path

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError
from sim.base.reading import reading
from sim.dataset.boundary_table import is_of_study, read_table
from sim.parameters import SYSTEMS

#: Group of the dataset with one subgroup per point whose particles are kept.
PARTICLES = "states"


@dataclass(frozen=True)
class Results:
    """The dataset of a study, loaded.

    Attributes
    ----------
    dataset : xarray.Dataset
        Scalars over (point, replicate), every parameter a coordinate over point.
    profiles : dict of str to xarray.Dataset
        Per system its profiles over (run, replicate, slice), with ``height`` (run, slice) in m; of
        a belt also those over (run, replicate, square) along it, with ``column`` (run, square) in
        m; ``run`` is the id of the point.
    boundaries : pandas.DataFrame
        What was found of boundaries between regimes.
    states : dict of str to xarray.Dataset
        Per point that feeds a figure of particles: last state and path of its first completed
        replicate.
    """

    dataset: xr.Dataset
    profiles: dict[str, xr.Dataset]
    boundaries: pd.DataFrame
    states: dict[str, xr.Dataset] = field(default_factory=dict)

    def profile(self, point: str, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return a profile of a point, (R, H) over completed replicates, and heights (H,) in m.

        Profiles along the belt come with the columns' centres instead of heights.

        Raises
        ------
        InputError
            When the dataset has no such profile of the point.
        """
        row = self.dataset.sel(point=point)
        one = self.profiles.get(str(row["system"].values), xr.Dataset())
        if name not in one or point not in one["run"]:
            raise InputError(f"{point}: no {name} in the dataset")
        one = one.sel(run=point)
        completed = np.flatnonzero(row["status"].values == "completed")
        values = one[name].isel(replicate=completed).values
        centres = one["column" if "square" in one[name].dims else "height"].values
        real = np.isfinite(centres)
        return values[:, real], centres[real]

    def particles(self, point: str) -> xr.Dataset:
        """Return last state and path of the particles of a point."""
        if point not in self.states:
            raise InputError(f"{point}: no particles in the dataset")
        return self.states[point]


def load_results(path: str | Path) -> Results:
    """Load the dataset of a study.

    Raises
    ------
    InputError
        When it is missing or damaged, naming it. A damaged one of a study is set aside.
    """
    path = Path(path)
    with reading(path, "dataset", replaceable=is_of_study(path)):
        with netCDF4.Dataset(path) as file:
            groups = set(file.groups)
            points = list(file.groups[PARTICLES].groups) if PARTICLES in groups else []
        return Results(
            dataset=_loaded(path, None),
            profiles={name: _loaded(path, name) for name in SYSTEMS if name in groups},
            boundaries=read_table(path),
            states={point: _loaded(path, f"{PARTICLES}/{point}") for point in points},
        )


def _loaded(path: Path, group: str | None) -> xr.Dataset:
    with xr.open_dataset(path, engine="netcdf4", group=group) as opened:
        return opened.load()
