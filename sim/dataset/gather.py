"""Read from a run file what a dataset stores: scalars, measures, profiles, particles."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import checked_read, read_seal, read_summary
from sim.dataset.belt import column_means, cycle_means
from sim.dataset.measures import measures
from sim.dataset.rows import SINGLE, WORDS, Rows, row_arrays, row_scalars
from sim.dataset.run_file import Replicate, RunFile
from sim.engine.identity import numerics_of
from sim.engine.stored_run import stage_amounts
from sim.parameters.variables import SCALARS, variables_of

#: Without these attributes a file is no run file.
ATTRIBUTES = {"point_id", "system", "engine_version", "source_hash", "versions", "created"}

#: Variables of the last state that no figure draws.
_UNDRAWN = ("particle_spin", "orientation")

#: Path of the particles after the last sample, which animations need.
PATH_VARIABLES = ("path", "path_time")

#: Variables that figures of particles need: last state and path.
STATE_VARIABLES = (
    *(name for name in variables_of("particle") if name not in _UNDRAWN),
    *PATH_VARIABLES,
)


def read_run(
    path: Path, amounts: Mapping[str, float] | None = None, has_state: bool = False
) -> Rows:
    """Read the row of a run file in a dataset.

    Parameters
    ----------
    path : Path
        The file; its name is the id of its point.
    amounts : mapping, optional
        Amounts to read, see `sim.parameters.points`; all that the file holds if omitted.
    has_state : bool
        Read the state of the particles of the first completed replicate too.

    Raises
    ------
    InputError
        When there is no such file, or it holds less than these amounts.
    DamagedError
        When it cannot be read as the run that its name says; it is set aside.
    """
    with checked_read(path, "run file", replaceable=True, sealed=True):
        # The seal is read first: if another file takes this name in between, its seal differs from
        # the one noted here, and it is read again the next time.
        seal = read_seal(path)
        with netCDF4.Dataset(path) as file:
            run = RunFile(file, amounts, (read_summary(path) or {}).get("scalars"))
            _require_point(run, file, path.stem)
            if amounts and not run.is_enough:
                stored = _list_amounts(stage_amounts(file, amounts)[0])
                raise InputError(
                    f"{path}: holds {stored} of {_list_amounts(amounts)}; "
                    "rerun the study to let it grow"
                )
            origin = {"seal": seal, "wanted": amounts_text(amounts)} | _provenance(run.attrs)
            origin["adopted"] = ""
            values = _scalars(run) | _profiles(run)
            state = _state(run) if has_state else None
    return Rows(
        points=[path.stem],
        origin={name: [str(text)] for name, text in origin.items()},
        values={name: array[np.newaxis] for name, array in values.items()},
        states={} if state is None else {path.stem: state},
    )


def _require_point(run: RunFile, file: netCDF4.Dataset, point: str) -> None:
    """Raise ``ValueError`` for a file that is no run file, or that of another point."""
    is_run = run.attrs.keys() >= ATTRIBUTES and "particles" in run
    if not is_run or "replicate" not in file.dimensions:
        raise ValueError("no point in it")
    if run.attrs["point_id"] != point:
        raise ValueError(f"holds point {run.attrs['point_id']}")


def _provenance(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return engine, numerics, sources, libraries, date and caveat of a run file."""
    number = numerics_of(attributes)
    return {
        "engine_version": attributes["engine_version"],
        "numerics": "unknown" if number is None else str(number),
        "source_hash": attributes["source_hash"],
        "versions": attributes["versions"],
        "created": attributes["created"],
        "caveat": attributes.get("caveat", ""),
    }


def amounts_text(amounts: Mapping[str, float] | None) -> str:
    """Return the amounts of a point as JSON; equal amounts give equal texts."""
    return json.dumps(dict(amounts or {}), sort_keys=True)


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
    dimensions = {dimension for variable in variables.values() for dimension in variable.dims}
    coords = {str(name): run.variable(str(name)) for name in dimensions if name in run}
    return xr.Dataset(variables, coords, run.attrs)
