"""The runs of a study as one labelled table: ``dataset.nc`` over points and replicates."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import dask
import numpy as np
import xarray as xr

from sim.errors import InputError
from sim.files import replacing
from sim.parameters import SYSTEMS, field_info
from sim.regime_boundaries import GROUP, refined, table
from sim.study import Study, load_study

#: Blocks that the averaging window is cut into for the errors of the base forces.
BLOCKS = 10

#: Scalars per replicate that a run file may hold. A system without one of them gets NaN.
NUMBERS = (
    "velocity",
    "velocity_error",
    "acceleration",
    "acceleration_error",
    "max_overlap",
    "steps",
    "wall_time",
    "replicate_seed",
    "base_normal",
    "base_shear",
)

#: Reduced here from the time series of a chute run.
REDUCED = ("base_normal_error", "base_shear_error", "momentum_budget", "momentum_budget_error")
WORDS = ("regime", "status", "reason")

_CAVEAT = {"long_name": "what to know before trusting the point"}


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Combine the run files of a study into ``results/<study>/dataset.nc``.

    Parameters
    ----------
    study_path : str or Path
        The study file; its points name the run files in ``results/<study>/runs``, those of all
        rounds of refinement included.
    results : str or Path
        Folder of all results.

    Returns
    -------
    Path
        The file written. It appears complete or not at all. What was found of boundaries is in
        its group ``boundaries``.

    Raises
    ------
    InputError
        When a run file is missing or is not one, naming it.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    study = refined(study, folder / "runs")
    reads = [dask.delayed(read_run)(folder / "runs" / f"{point}.nc") for point in study.points]
    # One thread: the HDF5 library under netCDF-4 is not thread-safe.
    runs = dask.compute(*reads, scheduler="synchronous")
    output = folder / "dataset.nc"
    with replacing(output) as temporary:
        combine(runs, study).to_netcdf(temporary, engine="netcdf4")
        if study.boundaries:
            found = table(study, folder / "runs").to_xarray()
            found.to_netcdf(temporary, mode="a", group=GROUP, engine="netcdf4")
    return output


def read_run(path: Path) -> xr.Dataset:
    """Read what a dataset keeps of a run file: scalars per replicate, parameters, provenance.

    Time series of forces are reduced on the way, so that only small arrays stay in memory.

    Raises
    ------
    InputError
        When there is no such file, or it cannot be read as a run.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such run file; run the study first")
    try:
        with xr.open_dataset(path, engine="netcdf4") as run:
            if "point_id" not in run.attrs or "replicate" not in run.sizes:
                raise InputError(f"{path}: not a run file (no point_id or no replicates in it)")
            if run.attrs["point_id"] != path.stem:
                raise InputError(
                    f"{path}: holds point {run.attrs['point_id']}; delete it and rerun"
                )
            kept = [
                name
                for name, values in run.variables.items()
                if values.dims == () or name in {*NUMBERS, *WORDS}
            ]
            return run[kept].load().assign(_reduced(run))
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path}: cannot be read as a run file ({error}); delete it and rerun"
        ) from None


def combine(runs: Sequence[xr.Dataset], study: Study) -> xr.Dataset:
    """Line up runs along ``point`` and their replicates along ``replicate``.

    Parameters
    ----------
    runs : sequence of xarray.Dataset
        What `read_run` kept of the runs of the study, in the order of its points.
    study : Study
        Says which series and figures each point belongs to.

    Returns
    -------
    xarray.Dataset
        Variables over (point, replicate), padded with NaN and ``""`` where a point has fewer
        replicates than another; every parameter of both systems as a coordinate over ``point``,
        NaN or ``""`` where it is not one of the point's system.
    """
    replicates = max(run.sizes["replicate"] for run in runs)
    names = [name for name in (*NUMBERS, *REDUCED, *WORDS) if any(name in run for run in runs)]
    return xr.Dataset(
        {name: _padded(runs, name, replicates) for name in names},
        coords=_labels(runs, study)
        | _parameters(runs)
        | {"replicate": ("replicate", np.arange(replicates))},
        attrs={
            "Conventions": "CF-1.11",
            "title": study.title or study.name,
            "study": study.name,
            "engine_version": _distinct(runs, "engine_version"),
            "source_hash": _distinct(runs, "source_hash"),
            "versions": _distinct(runs, "versions"),
        },
    )


def _padded(runs: Sequence[xr.Dataset], name: str, replicates: int) -> Any:
    """Return one variable of all runs as an array over (point, replicate)."""
    shape = (len(runs), replicates)
    table = np.full(shape, "", object) if name in WORDS else np.full(shape, np.nan)
    for row, run in zip(table, runs, strict=True):
        if name in run:
            row[: run.sizes["replicate"]] = run[name].values
    attrs = next(run[name].attrs for run in runs if name in run)
    return ("point", "replicate"), table, attrs


def _reduced(run: xr.Dataset) -> dict[str, Any]:
    """Return what the force balance needs of a chute run's time series, N per replicate."""
    if "base_shear_force" not in run:
        return {}
    inside = run["time"].values > run["average_start"].values
    time = run["time"].values[inside]
    normal = run["base_normal_force"].values[:, inside]
    shear = run["base_shear_force"].values[:, inside]
    momentum = float(run["particles"] * run["mass"]) * run["mean_velocity"].values[:, inside]
    budget, budget_error = momentum_budget(time, shear, momentum)
    reduced = {
        "base_normal_error": (bounded_error(normal), "standard error of base_normal"),
        "base_shear_error": (bounded_error(shear), "standard error of base_shear"),
        "momentum_budget": (budget, "mean base shear plus rate of change of momentum along x"),
        "momentum_budget_error": (budget_error, "standard error of momentum_budget"),
    }
    return {
        name: ("replicate", values, {"units": "N", "long_name": long_name})
        for name, (values, long_name) in reduced.items()
    }


def bounded_error(series: np.ndarray) -> np.ndarray:
    """Return the standard error of the mean of a series whose sum stays bounded.

    What the base force of a steady flow lacks of the weight goes into momentum, so its time
    integral is bounded and block means are anticorrelated: the mean over B blocks is off by the
    spread of one block divided by B, not by its square root.

    Parameters
    ----------
    series : (..., T) array
        Means over successive intervals.

    Returns
    -------
    (...) array
        Not-a-number where there are fewer than two samples.
    """
    if series.shape[-1] < 2:
        return np.full(series.shape[:-1], np.nan)
    parts = np.array_split(series, min(BLOCKS, series.shape[-1]), axis=-1)
    return np.stack([part.mean(axis=-1) for part in parts]).std(axis=0, ddof=1) / len(parts)


def momentum_budget(
    time: np.ndarray, shear: np.ndarray, momentum: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean base shear plus rate of change of momentum, and its standard error, N.

    Newton's second law makes it the weight along the slope, steady or not. The difference of the
    mean momenta of two intervals is the force weighted by a ramp over the one, by 1 between and by
    a ramp over the other; a weight of one half stands for each ramp, and what fluctuates within
    these two intervals (as much as from one to the next) is the error.

    Parameters
    ----------
    time : (T,) array
        Ends of the intervals, s.
    shear, momentum : (R, T) arrays
        Means over the intervals: force on the plane (N) and momentum along the slope (kg m/s).

    Returns
    -------
    tuple of (R,) arrays
        Not-a-number where there are fewer than two samples.
    """
    if time.size < 2:
        return np.full(len(shear), np.nan), np.full(len(shear), np.nan)
    weights = np.ones(time.size)
    weights[[0, -1]] = 0.5
    change = (momentum[:, -1] - momentum[:, 0]) / (time[-1] - time[0])
    error = shear.std(axis=1, ddof=1) / (np.sqrt(6) * (time.size - 1))
    return np.average(shear, axis=1, weights=weights) + change, error


def _labels(runs: Sequence[xr.Dataset], study: Study) -> dict[str, Any]:
    """Return what names a point and where its run came from, as coordinates."""
    points = list(study.points.values())
    return {
        "point": ("point", [point.id for point in points], {"long_name": "point id"}),
        "series": _words(" ".join(point.series) for point in points),
        "figures": _words(" ".join(point.figures) for point in points),
        "caveat": _words((run.attrs.get("caveat", "") for run in runs), _CAVEAT),
        "run_source_hash": _words(run.attrs["source_hash"] for run in runs),
        "particles": ("point", [int(run["particles"]) for run in runs], {"units": "1"}),
    }


def _parameters(runs: Sequence[xr.Dataset]) -> dict[str, Any]:
    """Return every parameter of both systems as a coordinate with its unit."""
    names = {name: None for model in SYSTEMS.values() for name in model.model_fields}
    return {name: _parameter(runs, name) for name in names}


def _parameter(runs: Sequence[xr.Dataset], name: str) -> Any:
    values = [run[name].values.item() if name in run else None for run in runs]
    attrs = {"long_name": _declared(name, "description")}
    if any(isinstance(value, str) for value in values):
        return _words(("" if value is None else value for value in values), attrs)
    for kind in ("units", "comment"):
        given = {run.attrs["system"]: run[name].attrs.get(kind) for run in runs if name in run}
        # Two units in one attribute could be read by nobody; as a comment they can.
        kept = kind if len(set(given.values())) == 1 else "comment"
        if any(given.values()):
            attrs[kept] = "; ".join(filter(None, (attrs.get(kept), _by_system(given))))
    return "point", np.array([np.nan if value is None else value for value in values], float), attrs


def _by_system(texts: Mapping[str, str | None]) -> str:
    """Write a text per system, or once where the systems agree."""
    if len(set(texts.values())) == 1:
        return next(iter(texts.values()))
    return "; ".join(f"{system}: {text}" for system, text in texts.items() if text)


def _declared(name: str, what: str) -> str:
    """Join what the systems declare about a parameter, once where they agree."""
    rows = [field_info(model).get(name) for model in SYSTEMS.values()]
    return "; ".join(dict.fromkeys(getattr(row, what) for row in rows if row))


def _words(values: Any, attrs: Mapping[str, str] | None = None) -> Any:
    return "point", np.array(list(values), dtype=object), dict(attrs or {})


def _distinct(runs: Sequence[xr.Dataset], attribute: str) -> str:
    return ", ".join(dict.fromkeys(run.attrs[attribute] for run in runs))
