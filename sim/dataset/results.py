"""What a study has found, as figures and judges read it: its dataset, groups when asked for."""

from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.base.damage import checked_read
from sim.base.errors import InputError
from sim.dataset.added import with_added
from sim.dataset.boundary_table import is_of_study, read_table
from sim.dataset.grids import GRIDS, number_of, on_grid
from sim.dataset.rows import CENTRES
from sim.parameters import SYSTEMS

#: Parameters of all systems, `system` itself among them.
_PARAMETERS = tuple(dict.fromkeys(chain(*(model.model_fields for model in SYSTEMS.values()))))

#: Group of the dataset with one subgroup per point whose particles are kept.
PARTICLES = "states"

#: Group of the dataset that says of each row which run file it was read from, and which variables
#: that had.
RUNS = "runs"


@dataclass(frozen=True)
class Results:
    """The dataset of a study.

    Attributes
    ----------
    dataset : xarray.Dataset
        Scalars over (point, replicate), every parameter of all systems a coordinate over point,
        NaN or ``""`` where it is none of the point's; `of` leaves those out.
    profiles : mapping of str to xarray.Dataset
        Per system its profiles over (run, replicate, slice), with ``height`` (run, slice) in m; of
        a belt also those over (run, replicate, square) along it, with ``column`` (run, square) in
        m, and those over (run, replicate, moment) of its cycle, with ``cycle_phase`` (run, moment)
        in rad; ``run`` is the id of the point.
    boundaries : pandas.DataFrame
        What was found of boundaries between regimes.
    states : mapping of str to xarray.Dataset
        Per point that feeds a figure of particles: last state and path of its first completed
        replicate.
    runs : Path, optional
        Folder of the run files, for their time series.
    adopted : mapping of str to tuple of str
        Per point whose row was taken from an adopted dataset the name of that, and when it was run.
    grid : str
        One of `sim.dataset.grids.GRIDS`, on which profiles are if no other is asked for.
    """

    dataset: xr.Dataset
    profiles: Mapping[str, xr.Dataset]
    boundaries: pd.DataFrame
    states: Mapping[str, xr.Dataset] = field(default_factory=dict)
    runs: Path | None = None
    adopted: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    grid: str = "centres"

    def of(self, system: str) -> xr.Dataset:
        """Return the points of one system, without what only the other has."""
        if system not in list(SYSTEMS):
            raise InputError.of_value("of", "system", system, "one of " + ", ".join(SYSTEMS))
        held = self.dataset
        some = held.sel(point=held["system"] == system)
        others = [name for name in _PARAMETERS if name not in SYSTEMS[system].model_fields]
        for name in held.data_vars:
            if some[name].isnull().all() and not held[name].isnull().all():
                others.append(str(name))
        return some.drop_vars(others)

    def profile(self, point: str, name: str, grid: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Return a profile of a point, (R, H) over completed replicates, and heights (H,) in m.

        Profiles along the belt come with the columns' centres (m) instead of heights, those over
        its cycle with phases (rad). Those over the height above the belt are on one of the grids of
        `sim.dataset.grids`, however thin the slices are that the run has kept.

        Raises
        ------
        InputError
            When the dataset has no such profile of the point, or it is not known on that grid.
        """
        if not isinstance(point, str) or point not in self.dataset.indexes["point"]:
            raise InputError(f"{point}: no such point in the dataset")
        held, index = self.dataset.variables, self.dataset.indexes["point"].get_loc(point)
        system = str(held["system"].values[index])
        group = self.profiles.get(system, xr.Dataset())
        if name not in group.variables or point not in group.indexes["run"]:
            raise InputError(f"{point}: no {name} in the dataset")
        row, profiles = group.indexes["run"].get_loc(point), group.variables
        completed = held["status"].values[index] == "completed"
        values = profiles[name].values[row][completed]
        axis = str(profiles[name].dims[-1])
        centres = profiles[CENTRES[axis]].values[row]
        real = np.isfinite(centres)
        values, centres = values[:, real], centres[real]
        if axis != "slice" or system != "belt":
            return values, centres
        beads = profiles.get(number_of(name))
        number = None if beads is None else beads.values[row][completed][:, real]
        diameter = float(held["diameter"].values[index])
        if (grid := grid or self.grid) not in GRIDS:
            raise InputError.of_value("profile", "grid", grid, "one of " + ", ".join(GRIDS))
        try:
            return on_grid(grid, diameter, centres, name, values, number)
        except ValueError as error:
            raise InputError(f"{point}: {name} {error}") from None

    def particles(self, point: str) -> xr.Dataset:
        """Return last state and path of the particles of a point."""
        if not isinstance(point, str) or point not in self.states:
            raise InputError(f"{point}: no particles in the dataset")
        return self.states[point]


class Groups(Mapping[str, xr.Dataset]):
    """Groups of a dataset by name, each read from the file when it is first asked for.

    Parameters
    ----------
    path : Path
        The dataset.
    paths : mapping
        Where in it each group is.
    """

    def __init__(self, path: Path, paths: Mapping[str, str]):
        self._path, self._paths = path, paths
        self._loaded: dict[str, xr.Dataset] = {}

    def __getitem__(self, name: str) -> xr.Dataset:
        if name not in self._loaded:
            group = self._paths[name]
            with _reading(self._path):
                self._loaded[name] = _loaded(self._path, group)
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self._paths

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


def load_results(path: str | Path) -> Results:
    """Load the dataset of a study; profiles and particles are read when they are asked for.

    Raises
    ------
    InputError
        When it is missing or damaged, naming it. A damaged one of a study is set aside.
    """
    path = Path(path)
    with _reading(path):
        with netCDF4.Dataset(path) as file:
            groups = set(file.groups)
            points = list(file.groups[PARTICLES].groups) if PARTICLES in groups else []
            adopted = _adopted(file) if RUNS in groups else {}
        return Results(
            dataset=_with_all_parameters(_loaded(path, None)),
            profiles=Groups(path, {name: name for name in SYSTEMS if name in groups}),
            boundaries=read_table(path),
            states=Groups(path, {point: f"{PARTICLES}/{point}" for point in points}),
            runs=path.parent / "runs",
            adopted=adopted,
        )


def _adopted(file: netCDF4.Dataset) -> dict[str, tuple[str, str]]:
    made = file.groups[RUNS].variables
    if "adopted" not in made:
        return {}
    columns = (file["point"], made["adopted"], made["created"])
    table = zip(*(column[:].tolist() for column in columns), strict=True)
    return {point: (dataset, created) for point, dataset, created in table if dataset}


def load(results: str | Path) -> Results:
    """Load what a study has found.

    Parameters
    ----------
    results : str or Path
        The folder of its results, or the dataset in it.

    Raises
    ------
    InputError
        When there is no dataset, or it is damaged.
    """
    if not isinstance(results, (str, Path)):
        allowed = "the path of a study's results or of a dataset"
        raise InputError.of_value("load", "results", results, allowed)
    path = Path(results)
    return load_results(path / "dataset.nc" if path.is_dir() else path)


def _reading(path: Path) -> AbstractContextManager[None]:
    return checked_read(path, "dataset", replaceable=is_of_study(path), sealed=True)


def _with_all_parameters(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with the parameters of all systems, those from after it included."""
    held = {str(name): values.values for name, values in dataset.coords.variables.items()}
    none = np.full(dataset.sizes["point"], np.nan)
    lacking = (name for name in _PARAMETERS if name not in held)
    columns = dict.fromkeys(lacking, none) | with_added(held)
    return dataset.assign_coords({name: ("point", values) for name, values in columns.items()})


def _loaded(path: Path, group: str | None) -> xr.Dataset:
    with xr.open_dataset(path, engine="netcdf4", group=group) as opened:
        return opened.load()
