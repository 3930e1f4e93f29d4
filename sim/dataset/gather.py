"""What a dataset keeps of one run file: scalars, measures, profiles, and the state of particles."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import netCDF4
import numpy as np
import xarray as xr

from sim.base.reading import reading
from sim.dataset.measures import MEASURES, measures
from sim.dataset.measures.belt import columns
from sim.dataset.run_file import Replicate, RunFile
from sim.engine.identity import numerics_of
from sim.engine.observe.arrays import INSTANTANEOUS, PROFILES, SNAPSHOTS
from sim.engine.observe.scalars import SCALARS

#: Without these attributes a file is no run file.
ATTRIBUTES = {"point_id", "system", "engine_version", "source_hash", "versions", "created"}

#: Scalars per replicate that a run file or its measures may hold. A system without one of them gets
#: NaN.
NUMBERS = tuple(name for name, (unit, _) in (SCALARS | MEASURES).items() if unit)
WORDS = tuple(name for name, (unit, _) in SCALARS.items() if not unit)

#: Profiles of which figures show the last sample beside the average.
_SHOWN_LAST = ("velocity_profile", "packing_profile")

#: Arrays over height that a dataset keeps.
OVER_HEIGHT = tuple(
    one
    for name in PROFILES
    for one in (name, name + INSTANTANEOUS)
    if one in PROFILES or name in _SHOWN_LAST
)

#: What no picture of particles shows.
_UNSEEN = ("particle_spin", "orientation")

#: What a picture of particles needs: last state and path.
STATE = (*(name for name in SNAPSHOTS if name not in _UNSEEN), "path", "path_time")


class Gathered(NamedTuple):
    """What is kept of one run: ``profiles`` over slices and squares by name; ``state`` only where a
    figure shows particles."""

    scalars: xr.Dataset
    profiles: dict[str, xr.Variable]
    state: xr.Dataset | None


def read_run(path: Path, shown: bool = False) -> Gathered:
    """Read what a dataset keeps of a run file.

    Parameters
    ----------
    path : Path
        The file; its name is the id of its point.
    shown : bool
        Keep the state of the particles of the first completed replicate.

    Raises
    ------
    InputError
        When there is no such file.
    DamagedError
        When it cannot be read as the run that its name says; it is set aside.
    """
    with reading(path, "run file", replaceable=True), netCDF4.Dataset(path) as file:
        run = RunFile(file)
        known = run.attrs.keys() >= ATTRIBUTES and "particles" in run
        if not known or "replicate" not in file.dimensions:
            raise ValueError("no point in it")
        if run.attrs["point_id"] != path.stem:
            raise ValueError(f"holds point {run.attrs['point_id']}")
        kept = {name: run.variable(name) for name in run if not run.dims(name) or name in SCALARS}
        made = {
            name: xr.Variable("replicate", values, _described(name))
            for name, values in measures(run).items()
        }
        number = numerics_of(run.attrs)
        attrs = run.attrs | {"numerics": "unknown" if number is None else str(number)}
        scalars = xr.Dataset(kept | made, attrs=attrs)
        return Gathered(scalars, _profiles(run), _state(run) if shown else None)


def lined_up(runs: Sequence[Mapping[str, xr.Variable]], along: str, replicates: int) -> xr.Dataset:
    """Return the variables of all runs along a new dimension, without coordinates.

    Fewer ``replicates`` than asked for, arrays shorter than those of another run and those that a
    run lacks are filled up with NaN or ``""``. Attributes are those in the first run that has the
    variable.
    """
    found = {}
    for name in dict.fromkeys(name for run in runs for name in run):
        given = [run.get(name) for run in runs]
        some = [one for one in given if one is not None]
        first, sizes = some[0], np.max([one.shape for one in some], axis=0, initial=0)
        size = dict(zip(first.dims, map(int, sizes), strict=True)) | {"replicate": replicates}
        shape = (len(runs), *(size[dimension] for dimension in first.dims))
        if name in WORDS:
            table = np.full(shape, "", object)
        else:
            table = np.full(shape, np.nan, np.result_type(first.dtype, np.float32))
        for row, one in zip(table, given, strict=True):
            if one is not None:
                row[tuple(map(slice, one.shape))] = one.values
        found[name] = ((along, *first.dims), table, first.attrs)
    return xr.Dataset(found)


def _described(name: str) -> dict[str, str]:
    unit, long_name = MEASURES[name]
    return {"units": unit, "long_name": long_name}


def _profiles(run: RunFile) -> dict[str, xr.Variable]:
    """Return profiles over height and along the belt, and the places of their slices and squares.

    In single precision: seven digits, of which statistics know three.
    """
    kept = {name: run.variable(name) for name in OVER_HEIGHT if name in run} | columns(run)
    found = {
        name: xr.Variable(
            ["slice" if dimension == "height" else dimension for dimension in one.dims],
            one.values.astype(np.float32),
            one.attrs,
        )
        for name, one in kept.items()
    }
    places = {"height": xr.Variable("slice", run["height"])} if "height" in run else {}
    return {**places, **found}


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


def profiles(runs: Sequence[Gathered], replicates: int) -> xr.Dataset:
    """Return the profiles of the runs of one system over (run, replicate, slice).

    Coordinate ``run`` is the id of the point. Fewer slices or replicates than those of another run
    are filled up with NaN; ``height`` (run, slice) holds the centres of the slices. Profiles along
    the belt are over (run, replicate, square), and ``column`` (run, square) holds the centres.
    """
    ids = [run.scalars.attrs["point_id"] for run in runs]
    together = lined_up([run.profiles for run in runs], "run", replicates)
    return together.drop_attrs().assign_coords(run=ids)
