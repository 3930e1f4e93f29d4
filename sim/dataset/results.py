"""The results of a study as figures and judges read them; groups are read at first access."""

from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.base.additions import plugin_options
from sim.base.errors import InputError
from sim.base.messages import one_of
from sim.base.seals import checked_read
from sim.dataset.grids import GRIDS, number_density_name, open_group, regrid
from sim.dataset.rounds import RESULT_COLUMNS
from sim.dataset.rows import CENTRES, PARTICLES
from sim.parameters import SYSTEMS, Parameters, amounts, defaults_of_added, parse_point
from sim.parameters.laws import FunctionParameters
from sim.study.model import Study

#: Parameters of all systems, including `system` itself.
_PARAMETERS = tuple(dict.fromkeys(chain(*(model.model_fields for model in SYSTEMS.values()))))

#: Group of the dataset with the table, one row per boundary.
GROUP = "boundaries"

#: All columns of a table without rows.
COLUMNS = ("name", "system", "of", "along", "unit", "figures", *RESULT_COLUMNS)

#: Fields that identify a boundary in a study and in its dataset.
_BOUNDARY_KEYS = ("name", "of", "along")


@dataclass(frozen=True)
class Results:
    """The dataset of a study.

    Attributes
    ----------
    dataset : xarray.Dataset
        Scalars over (point, replicate), every parameter of all systems a coordinate over point,
        NaN or ``""`` where the point's system does not have it; `of` leaves those out.
    profiles : mapping of str to xarray.Dataset
        Per system its profiles over (run, replicate, slice), with ``height`` (run, slice) in m. A
        belt also has profiles along it over (run, replicate, square), with ``column`` (run, square)
        in m, and profiles over its cycle (run, replicate, moment), with ``cycle_phase`` (run,
        moment) in rad. ``run`` is the id of the point.
    boundaries : pandas.DataFrame
        Table of the boundaries between regimes, see `sim.dataset.boundaries.tabulate`.
    states : mapping of str to xarray.Dataset
        Per point that feeds a figure of particles: last state and path of its first completed
        replicate.
    runs : Path, optional
        Folder of the run files, for their time series.
    grid : str
        Default grid of profiles, one of `sim.dataset.grids.GRIDS`.
    """

    dataset: xr.Dataset
    profiles: Mapping[str, xr.Dataset]
    boundaries: pd.DataFrame
    states: Mapping[str, xr.Dataset] = field(default_factory=dict)
    runs: Path | None = None
    grid: str = "centres"

    def of(self, system: str) -> xr.Dataset:
        """Return the points of one system, without variables that only other systems have."""
        dataset = self.dataset
        if system not in [*SYSTEMS, *dataset["system"].values]:
            raise InputError.of_value("of", "system", system, one_of(system, SYSTEMS))
        rows = dataset.sel(point=dataset["system"] == system)
        others = [name for name in _PARAMETERS if name not in fields_of(system)]
        for name in dataset.data_vars:
            if rows[name].isnull().all() and not dataset[name].isnull().all():
                others.append(str(name))
        return rows.drop_vars(others, errors="ignore")

    def profile(self, point: str, name: str, grid: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Return a profile of a point, (R, H) over completed replicates, and heights (H,) in m.

        Profiles along the belt come with the centres of the columns (m) instead of heights, those
        over its cycle with phases (rad). Profiles over the height above the belt are put on a grid
        of `sim.dataset.grids`, which may be coarser than the slices of the run.

        Raises
        ------
        InputError
            When the dataset has no such profile of the point, or cannot put it on that grid.
        """
        if not isinstance(point, str) or point not in self.dataset.indexes["point"]:
            raise InputError(f"{point}: no such point in the dataset")
        variables, index = self.dataset.variables, self.dataset.indexes["point"].get_loc(point)
        system = str(variables["system"].values[index])
        group = self.profiles.get(system, xr.Dataset())
        if name not in group.variables or point not in group.indexes["run"]:
            raise InputError(f"{point}: no {name} in the dataset")
        row, profiles = group.indexes["run"].get_loc(point), group.variables
        completed = variables["status"].values[index] == "completed"
        values = profiles[name].values[row][completed]
        axis = str(profiles[name].dims[-1])
        centres = profiles[CENTRES[axis]].values[row]
        is_slice = np.isfinite(centres)
        values, centres = values[:, is_slice], centres[is_slice]
        if axis != "slice" or system != "belt":
            return values, centres
        density = profiles.get(number_density_name(name))
        number = None if density is None else density.values[row][completed][:, is_slice]
        diameter = float(variables["diameter"].values[index])
        if (grid := grid or self.grid) not in GRIDS:
            raise InputError.of_value("profile", "grid", grid, "one of " + ", ".join(GRIDS))
        try:
            return regrid(grid, diameter, centres, name, values, number)
        except ValueError as error:
            raise InputError(f"{point}: {name} {error}") from None

    def particles(self, point: str) -> xr.Dataset:
        """Return the last state and the path of the particles of a point."""
        if not isinstance(point, str) or point not in self.states:
            raise InputError(f"{point}: no particles in the dataset")
        return self.states[point]


def fields_of(system: str) -> Mapping[str, Any]:
    """Return the parameters of a system; of a function that is not loaded, those of all."""
    return SYSTEMS.get(system, FunctionParameters).model_fields


class Groups(Mapping[str, xr.Dataset]):
    """Groups of a dataset by name, each read from the file at its first access.

    ``paths`` are those of the groups in the dataset, by name.
    """

    def __init__(self, path: Path, paths: Mapping[str, str]):
        self._path, self._paths = path, paths
        self._loaded: dict[str, xr.Dataset] = {}

    def __getitem__(self, name: str) -> xr.Dataset:
        if name not in self._loaded:
            path = self._paths[name]
            with _checked_dataset(self._path), netCDF4.Dataset(self._path) as file:
                self._loaded[name] = open_group(file, path).load()
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self._paths

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


def load_results(results: str | Path) -> Results:
    """Load the results of a study: profiles and particles are read at their first access.

    ``results`` is their folder, or the dataset in it. Raises `InputError` when there is no dataset,
    or it is damaged; the message names it. A damaged dataset of a study is set aside.
    """
    if not isinstance(results, (str, Path)):
        allowed = "the path of a study's results or of a dataset"
        raise InputError.of_value("load", "results", results, allowed)
    path = Path(results)
    path = path / "dataset.nc" if path.is_dir() else path
    # A file of many variables takes long to open, so that it is opened once.
    with _checked_dataset(path), netCDF4.Dataset(path) as file:
        groups = set(file.groups)
        points = list(file.groups[PARTICLES].groups) if PARTICLES in groups else []
        return Results(
            dataset=with_all_parameters(open_group(file, None).load()),
            profiles=Groups(path, {name: name for name in SYSTEMS if name in groups}),
            boundaries=_read_boundaries(file),
            states=Groups(path, {point: f"{PARTICLES}/{point}" for point in points}),
            runs=path.parent / "runs",
        )


def _checked_dataset(path: Path) -> AbstractContextManager[None]:
    # It lies where the workflow makes it, next to its runs.
    is_of_study = path.name == "dataset.nc" and (path.parent / "runs").is_dir()
    return checked_read(path, "dataset", replaceable=is_of_study, sealed=True)


def with_all_parameters(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with the parameters of all systems, including those added after it."""
    coords = {str(name): values.values for name, values in dataset.coords.variables.items()}
    none = np.full(dataset.sizes["point"], np.nan)
    lacking = (name for name in _PARAMETERS if name not in coords)
    columns = dict.fromkeys(lacking, none) | added_columns(coords)
    return dataset.assign_coords({name: ("point", values) for name, values in columns.items()})


def _read_boundaries(file: netCDF4.Dataset) -> pd.DataFrame:
    if GROUP not in file.groups:
        return pd.DataFrame(columns=COLUMNS)
    table = open_group(file, GROUP).load().to_dataframe()
    return table.assign(**added_columns({name: table[name].to_numpy() for name in table}))


def added_columns(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns of all added parameters, with the default where a row has no value.

    ``columns`` are arrays over rows: ``system`` and parameters, NaN or ``""`` where a row has none.
    """
    systems = np.asarray(columns["system"])
    filled: dict[str, np.ndarray] = {}
    for system in sorted(set(systems) & SYSTEMS.keys()):
        for name, default in defaults_of_added(system).items():
            is_text = isinstance(default, str)
            kind, none = (object, "") if is_text else (float, np.nan)
            values = filled.get(name, columns.get(name, np.full(len(systems), none, kind)))
            blank = values == "" if is_text else np.isnan(values)
            filled[name] = np.where((systems == system) & blank, default, values)
    return filled


def parameters_of_row(columns: Mapping[str, np.ndarray], row: int) -> Parameters:
    """Return the parameters of a row of a dataset, whose switches and counts are numbers."""
    fields = SYSTEMS[str(columns["system"][row])].model_fields
    values = {name: columns[name][row] for name in fields if name in columns}
    for name, value in values.items():
        kind = fields[name].annotation
        values[name] = kind(value) if kind in (bool, int, float) else str(value)
    return parse_point(values, "results")


def require_known_options(dataset: xr.Dataset, path: Path) -> None:
    """Refuse points with laws or motions of plug-ins that are not loaded.

    Their parameters are not known, so two points that differ in one would be taken for the same.
    """
    for choice in ("law", "motion", "function"):
        loaded = plugin_options(choice)
        for name in map(str, dataset[choice].values if choice in dataset.coords else ()):
            # The name of an option of a plug-in ends in its hash.
            if "." in name and name not in loaded:
                allowed = "one of Talus, or of a plug-in that TALUS_PLUGINS names"
                raise InputError.of_value(str(path), choice, name, allowed)


def load_current(study: Study, folder: Path, *, title: bool = True) -> Results:
    """Load the dataset of a study from its folder of results; it must be of the present study file.

    Without ``title`` it may have had another title. Raises `InputError` when there is no dataset,
    or it is damaged, or it was made from another study file or from this one before an edit; the
    message names the study file and the difference.
    """
    path = folder / "dataset.nc"
    results = load_results(path)
    for label, ours, theirs in _comparisons(study, results):
        if ours != theirs and (title or label != "title"):
            raise InputError(f"{study.path}: {label}: not as in {path}; run the study again")
    return results


def _comparisons(study: Study, results: Results) -> Iterator[tuple[str, Any, Any]]:
    """Yield the label of each compared value, the value in the study, and that in the dataset."""
    dataset = results.dataset
    yield "study", study.name, dataset.attrs.get("study")
    yield "title", study.title or study.name, dataset.attrs.get("title")
    ids = dataset["point"].values.tolist() if "point" in dataset.coords else []
    # The points that rounds of refinement have added come last.
    ids = ids[: len(study.points)] if study.rounds else ids
    for point in sorted(study.points.keys() ^ set(ids)):
        yield f"point {point}", point in study.points, point in ids
    yield "order of points", list(study.points), ids
    for kind in ("series", "figures"):
        for point, text in zip(study.points.values(), dataset[kind].values, strict=False):
            ours, theirs = set(getattr(point, kind)), set(str(text).split())
            # A round may have added a point of another series to a boundary.
            yield f"{kind} of {point.id}", ours, theirs & ours if study.rounds else theirs
    for index, point in enumerate(study.points.values()):
        for name, value in amounts(point.parameters).items():
            yield f"{name} of {point.id}", value, float(dataset[name].values[index])
    keys = [
        tuple(getattr(boundary, name) for name in _BOUNDARY_KEYS) for boundary in study.boundaries
    ]
    table = results.boundaries
    yield "boundaries", keys, list(zip(*(table[name] for name in _BOUNDARY_KEYS), strict=True))
