"""What a dataset keeps of one run file: scalars, measures, profiles, and the state of particles."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from sim.base.reading import reading
from sim.dataset.measures import MEASURES, measures
from sim.dataset.measures.belt import columns
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
    """What is kept of one run; ``state`` only where a figure shows particles."""

    scalars: xr.Dataset
    profiles: xr.Dataset
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
    with (
        reading(path, "run file", replaceable=True),
        xr.open_dataset(path, engine="netcdf4") as run,
    ):
        if not {*run.attrs} >= ATTRIBUTES or "replicate" not in run.sizes or "particles" not in run:
            raise ValueError("no point in it")
        if run.attrs["point_id"] != path.stem:
            raise ValueError(f"holds point {run.attrs['point_id']}")
        kept = [
            name for name, values in run.variables.items() if values.dims == () or name in SCALARS
        ]
        made = {
            name: ("replicate", values, _described(name)) for name, values in measures(run).items()
        }
        scalars = run[kept].load().assign(made)
        number = numerics_of(run.attrs)
        scalars.attrs["numerics"] = "unknown" if number is None else str(number)
        return Gathered(
            scalars,
            _single(run[[name for name in OVER_HEIGHT if name in run]].assign(columns(run))),
            _state(run) if shown else None,
        )


def lined_up(runs: Sequence[xr.Dataset], along: str, replicates: int) -> xr.Dataset:
    """Return the variables of all runs along a new dimension, without coordinates.

    Fewer ``replicates`` than asked for, arrays shorter than those of another run and those that a
    run lacks are filled up with NaN or ``""``. Attributes are those in the first run that has the
    variable.
    """
    names = dict.fromkeys(name for run in runs for name in run.sizes)
    sizes = {name: max(run.sizes.get(name, 0) for run in runs) for name in names}
    sizes |= {"replicate": replicates}
    found = {}
    for name in dict.fromkeys(name for run in runs for name in run.data_vars):
        given = [run[name].variable if name in run else None for run in runs]
        first = next(one for one in given if one is not None)
        shape = (len(runs), *(sizes[dimension] for dimension in first.dims))
        if name in WORDS:
            table = np.full(shape, "", object)
        else:
            table = np.full(shape, np.nan, np.result_type(first.dtype, np.float32))
        for row, one in zip(table, given, strict=True):
            if one is not None:
                row[tuple(map(slice, one.shape))] = one.values
        found[name] = ((along, *first.dims), table, first.attrs)
    return xr.Dataset(found)


def _single(arrays: xr.Dataset) -> xr.Dataset:
    """Return arrays in single precision: seven digits, of which statistics know three."""
    return arrays.load().astype(np.float32)


def _described(name: str) -> dict[str, str]:
    unit, long_name = MEASURES[name]
    return {"units": unit, "long_name": long_name}


def _state(run: xr.Dataset) -> xr.Dataset | None:
    """Return last state and path of the particles of the first completed replicate, if any."""
    completed = np.flatnonzero(run["status"].values == "completed")
    if not completed.size or "position" not in run:
        return None
    one = run[[name for name in STATE if name in run]].isel(replicate=completed[0])
    return _single(one.isel(frame=-1)).reset_coords(drop=True)


def profiles(runs: Sequence[Gathered], replicates: int) -> xr.Dataset:
    """Return the profiles of the runs of one system over (run, replicate, slice).

    Coordinate ``run`` is the id of the point. Fewer slices or replicates than those of another run
    are filled up with NaN; ``height`` (run, slice) holds the centres of the slices. Profiles along
    the belt are over (run, replicate, square), and ``column`` (run, square) holds the centres.
    """
    own = [
        run.profiles.reset_index("height").reset_coords("height").rename_dims(height="slice")
        for run in runs
    ]
    ids = [run.scalars.attrs["point_id"] for run in runs]
    return lined_up(own, "run", replicates).drop_attrs().assign_coords(run=ids)
