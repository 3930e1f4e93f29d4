"""What a dataset keeps of a run file: scalars, measures, profiles, and the state of particles."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from sim.base.damage import checked_read
from sim.base.errors import InputError
from sim.base.files import read_seal
from sim.base.summary import read_summary
from sim.dataset.measures import measures
from sim.dataset.measures.belt import columns, over_cycle
from sim.dataset.rows import SINGLE, WORDS, Rows, row_arrays, row_scalars
from sim.dataset.run_file import Replicate, RunFile
from sim.engine.identity import numerics_of
from sim.engine.stored_run import held_amounts
from sim.parameters.variables import SCALARS, variables

#: Without these attributes a file is no run file.
ATTRIBUTES = {"point_id", "system", "engine_version", "source_hash", "versions", "created"}

#: What no picture of particles shows.
_UNSEEN = ("particle_spin", "orientation")

#: Their path after the last sample, which animations need.
PATH = ("path", "path_time")

#: What pictures of particles need: last state and path.
STATE = (*(name for name in variables("particle") if name not in _UNSEEN), *PATH)


def read_run(path: Path, wanted: Mapping[str, float] | None = None, shown: bool = False) -> Rows:
    """Read what a dataset keeps of a run file: one row.

    Parameters
    ----------
    path : Path
        The file; its name is the id of its point.
    wanted : mapping, optional
        How much is wanted of the point, see `sim.parameters.amounts`; all that is held if omitted.
    shown : bool
        Keep the state of the particles of the first completed replicate.

    Raises
    ------
    InputError
        When there is no such file, or it holds less than is wanted.
    DamagedError
        When it cannot be read as the run that its name says; it is set aside.
    """
    with checked_read(path, "run file", replaceable=True, sealed=True):
        # First: if another file takes the name in between, its numbers get a seal that is not its
        # own, and it is read again the next time.
        seal = read_seal(path)
        with netCDF4.Dataset(path) as file:
            run = RunFile(file, wanted, (read_summary(path) or {}).get("scalars"))
            _require_point(run, file, path.stem)
            if wanted and not run.is_enough:
                held = _listed(held_amounts(file, wanted)[0])
                raise InputError(
                    f"{path}: holds {held} of {_listed(wanted)}; rerun the study to let it grow"
                )
            origin = {"seal": seal, "wanted": as_text(wanted)} | _made_by(run.attrs)
            origin["adopted"] = ""
            values = _scalars(run) | _profiles(run)
            state = _state(run) if shown else None
    return Rows(
        points=[path.stem],
        origin={name: [str(text)] for name, text in origin.items()},
        values={name: held[np.newaxis] for name, held in values.items()},
        states={} if state is None else {path.stem: state},
    )


def _require_point(run: RunFile, file: netCDF4.Dataset, point: str) -> None:
    """Refuse, with ``ValueError``, a file that is no run file or one of another point."""
    known = run.attrs.keys() >= ATTRIBUTES and "particles" in run
    if not known or "replicate" not in file.dimensions:
        raise ValueError("no point in it")
    if run.attrs["point_id"] != point:
        raise ValueError(f"holds point {run.attrs['point_id']}")


def _made_by(attributes: Mapping[str, Any]) -> dict[str, Any]:
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


def as_text(wanted: Mapping[str, float] | None) -> str:
    """Return how much is wanted of a point as a text that is the same for the same amounts."""
    return json.dumps(dict(wanted or {}), sort_keys=True)


def _listed(much: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:g}" for name, value in much.items())


def _scalars(run: RunFile) -> dict[str, np.ndarray]:
    """Return scalars and measures, each over replicates."""
    held = {name: run[name] for name in SCALARS if name in run} | measures(run)
    known = [name for name in row_scalars() if name in held]
    return {name: held[name].astype(object if name in WORDS else float) for name in known}


def _profiles(run: RunFile) -> dict[str, np.ndarray]:
    """Return profiles over height, along the belt and over its cycle, and where they lie."""
    held = {name: run[name] for name in row_arrays(run.attrs["system"]) if name in run}
    held |= columns(run) | over_cycle(run)
    return {name: one.astype(np.float32 if name in SINGLE else float) for name, one in held.items()}


def _state(run: RunFile) -> xr.Dataset | None:
    """Return last state and path of the particles of the first completed replicate, if any."""
    completed = np.flatnonzero(run["status"] == "completed")
    if not completed.size or "position" not in run:
        return None
    one, found = Replicate(run, int(completed[0])), {}
    for name in STATE:
        if name in run and name != "path_time":
            dims, values = run.dims(name), np.asarray(one[name])
            if "frame" in dims:
                values = values[-1]
            left = [dimension for dimension in dims if dimension not in ("replicate", "frame")]
            found[name] = xr.Variable(left, values.astype(np.float32), run.variable(name).attrs)
    used = {dimension for each in found.values() for dimension in each.dims}
    places = {str(name): run.variable(str(name)) for name in used if name in run}
    return xr.Dataset(found, places, run.attrs)
