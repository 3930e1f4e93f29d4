"""Read from a run file what a dataset stores: scalars, measures, profiles, particles."""

from collections.abc import Collection, Mapping
from math import nan, pi
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from sim.base.additions import attribute_errors_to
from sim.base.errors import InputError
from sim.base.seals import checked_read, read_seal, read_summary
from sim.dataset.grids import open_group
from sim.dataset.rows import (
    SINGLE,
    STATE_VARIABLES,
    WORDS,
    Row,
    amounts_text,
    row_arrays,
    row_scalars,
    stored_names,
)
from sim.engine.identity import numerics_of
from sim.engine.stored_run import STATE, Replicate, RunFile, amounts_of, require_all
from sim.parameters.variables import OBSERVABLE, SCALARS, Observable, observables
from sim.study.model import Need
from sim.study.plottable import Shown

#: Without these attributes a file is no run file.
ATTRIBUTES = {"point_id", "system", "engine_version", "source_hash", "versions", "created"}

#: What a dataset says of the origin of a row, besides how much of it is wanted.
ORIGIN = ("engine_version", "numerics", "source_hash", "versions", "created", "caveat")

#: The least that is needed of a run.
SCALARS_ALONE = Need(Shown.NOTHING, profiles=False)

#: Profiles over the cycle of the vibration, each with the time series that it averages.
OVER_CYCLE = {
    "cycle_normal_force": "belt_normal_force",
    "cycle_shear_force": "belt_shear_force",
    "cycle_contact_time": "belt_contact_time",
}


def read_run(
    path: Path, amounts: Mapping[str, float] | None = None, need: Need = SCALARS_ALONE
) -> Row:
    """Read the row of a run file, whole or reduced, in a dataset.

    The name of the file is the id of its point. ``amounts`` are those to read
    (`sim.parameters.points`), by default all that the file holds, and ``need`` is what is needed
    besides scalars. The particles are those of the first completed replicate. Raises `InputError`
    when there is no such file, or it holds less than these amounts, or a reduced one holds less
    than is needed, and `DamagedError` when it cannot be read as the run that its name says; it is
    set aside.
    """
    with checked_read(path, "run file", replaceable=True, sealed=True):
        # The seal is read first: if another file takes this name in between, its seal differs from
        # the one noted here, and it is read again the next time.
        seal = read_seal(path)
        with netCDF4.Dataset(path) as file:
            run = RunFile(file, amounts, (read_summary(path) or {}).get("scalars"))
            _require_point(run, file, path.stem)
            if amounts and not run.is_enough:
                stored = _list_amounts(amounts_of(file, amounts))
                raise InputError(
                    f"{path}: holds {stored} of {_list_amounts(amounts)}; "
                    "rerun the study to let it grow"
                )
            # Time series are for figures, which read them from run files.
            require_all(run.attrs, path, need._replace(series=False))
            origin: dict[str, Any] = {"seal": seal, "wanted": amounts_text(amounts)}
            origin |= {name: run.attrs.get(name, "") for name in ORIGIN} | {"adopted": ""}
            number = numerics_of(run.attrs)
            origin["numerics"] = "unknown" if number is None else number
            if "reduced" in run.attrs:
                origin |= {name: run.attrs[name] for name in ("seal", "adopted")}
                values, state = _row(run), _row_state(run, file)
            else:
                values = _scalars(run) | _profiles(run)
                state = _state(run) if need.particles else None
    return Row(path.stem, {name: str(text) for name, text in origin.items()}, values, state)


def _row(run: RunFile) -> dict[str, np.ndarray]:
    """Return the variables of a reduced run file that are known, as a whole one gives them."""
    names = stored_names()
    known = {
        name: run[name].astype(object if name in WORDS else np.float32 if name in SINGLE else float)
        for name in run.attrs["variables"].split()
        if name in names
    }
    # Observables that the writer of the dataset did not know.
    return known | measures(run, known)


def _row_state(run: RunFile, file: netCDF4.Dataset) -> xr.Dataset | None:
    """Return the particles in a reduced run file, if there are any."""
    is_there = STATE in file.groups and "completed" in run["status"]
    # A copy does not refer to the open file, which cannot be sent to another process.
    return open_group(file, STATE).load().copy() if is_there else None


def _require_point(run: RunFile, file: netCDF4.Dataset, point: str) -> None:
    """Raise ``ValueError`` for a file that is no run file, or that of another point."""
    is_run = run.attrs.keys() >= ATTRIBUTES and "particles" in run
    if not is_run or "replicate" not in file.dimensions:
        raise ValueError("it has no point")
    if run.attrs["point_id"] != point:
        raise ValueError(f"holds point {run.attrs['point_id']}")


def _list_amounts(amounts: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:g}" for name, value in amounts.items())


def _scalars(run: RunFile) -> dict[str, np.ndarray]:
    """Return scalars and measures, each over replicates."""
    arrays = {name: run[name] for name in SCALARS if name in run} | measures(run)
    names = [name for name in row_scalars() if name in arrays]
    return {name: arrays[name].astype(object if name in WORDS else float) for name in names}


def _profiles(run: RunFile) -> dict[str, np.ndarray]:
    """Return profiles over height, along the belt and over its cycle, with their coordinates."""
    arrays = {name: run[name] for name in row_arrays(run.attrs["system"]) if name in run}
    arrays |= column_means(run) | cycle_means(run)
    return {
        name: array.astype(np.float32 if name in SINGLE else float)
        for name, array in arrays.items()
    }


def _state(run: RunFile) -> xr.Dataset | None:
    """Return the last state and path of the particles of the first completed replicate, if any."""
    completed = np.flatnonzero(run["status"] == "completed")
    if not completed.size or "position" not in run:
        return None
    replicate, variables = Replicate(run, int(completed[0])), {}
    for name in STATE_VARIABLES:
        if name in run and name != "path_time":
            dims, values = run.dims(name), np.asarray(replicate[name])
            if "frame" in dims:
                values = values[-1]
            dims = tuple(name for name in dims if name not in ("replicate", "frame"))
            variables[name] = xr.Variable(dims, values.astype(np.float32), run.variable(name).attrs)
    names = dict.fromkeys(str(name) for variable in variables.values() for name in variable.dims)
    coords = {name: run.variable(name) for name in names if name in run}
    return xr.Dataset(variables, coords, run.attrs)


def measures(run: RunFile, known: Collection[str] = ()) -> dict[str, np.ndarray]:
    """Return observables of a run but for those ``known``, each an array over its replicates.

    They are NaN for replicates that failed.
    """
    declared, status = observables(run.attrs["system"]), run["status"]
    declared = {name: one for name, one in declared.items() if name not in known}
    table = {name: np.full(len(status), nan) for name in declared}
    for index in np.flatnonzero(status == "completed"):
        replicate = Replicate(run, int(index))
        for name, value in measure(replicate, declared, run.attrs["point_id"]).items():
            table[name][index] = value
    return table


def measure(
    replicate: Mapping[str, Any], declared: Mapping[str, Observable], point: str
) -> dict[str, float]:
    """Return observables of a replicate; NaN where its file lacks the arrays for one.

    Each function is called once, however many observables it measures. ``point`` is the id of the
    point, for errors, which name the observable and its plug-in.
    """
    results: dict[int, Any] = {}
    values = {}
    for name, one in declared.items():
        with attribute_errors_to(OBSERVABLE, name, f" of {point}"):
            key = id(one.measure)
            if key not in results:
                results[key] = one.measure(replicate)
            result = results[key]
            values[name] = float(result.get(name, nan) if isinstance(result, Mapping) else result)
    return values


def column_means(run: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return velocity and density along the belt, averaged over all levels of the field.

    These are ``column_velocity`` (m/s) and ``column_density`` (beads per length, m⁻¹), each over
    (replicate, square), and ``column`` (square,), the centres of the squares along the belt (m).
    Empty for a run without a field.
    """
    if "field_velocity" not in run:
        return {}
    density, level = np.asarray(run["field_density"]), np.asarray(run["level"])
    moved = np.nansum(np.asarray(run["field_velocity"]) * density, axis=-1)
    beads = np.nansum(density, axis=-1)
    return {
        "column_velocity": np.divide(moved, beads, out=np.full_like(beads, nan), where=beads > 0),
        "column_density": beads * float(level[1] - level[0]),
        "column": np.asarray(run["column"]),
    }


def cycle_means(run: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return forces on the belt and contact time against its phase, averaged over the window.

    These are ``cycle_normal_force`` and ``cycle_shear_force`` (N), and ``cycle_contact_time``, each
    over (replicate, moment). ``cycle_phase`` (moment,) is the phase of the belt (rad) in the middle
    of each averaging interval. Empty for a run that has not recorded these series.
    """
    if "belt_normal_force" not in run:
        return {}
    number = int(run["samples_per_cycle"])
    moment = np.round(np.asarray(run["belt_phase"]) / (2 * pi) * number) % number
    start = np.asarray(run["average_start"])[:, None]
    profiles = {}
    for name, series in OVER_CYCLE.items():
        values = np.asarray(run[series])
        is_counted = (np.asarray(run["time"]) > start) & np.isfinite(values)
        profiles[name] = np.full((len(values), number), nan)
        for k in range(number):
            is_at_moment = is_counted & (moment == k)
            np.divide(
                np.where(is_at_moment, values, 0.0).sum(axis=1),
                is_at_moment.sum(axis=1),
                out=profiles[name][:, k],
                where=is_at_moment.any(axis=1),
            )
    # A sample is the mean over the interval that ends with it; the middle is half a sample earlier.
    return profiles | {"cycle_phase": (np.arange(number) - 0.5) * 2 * pi / number}
