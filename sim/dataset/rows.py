"""Runs as rows of arrays: the variables of each row, and how rows are aligned."""

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sim.base.additions import codes
from sim.base.program import files_hash, room_hash
from sim.engine import identity
from sim.engine.stored_run import measured_names
from sim.parameters import SYSTEMS
from sim.parameters.variables import (
    OBSERVABLE,
    SCALARS,
    Variable,
    observable_variables,
    variables_of,
)
from sim.study.plot_kinds import Shown

if TYPE_CHECKING:
    # Not imported otherwise: plans of studies use these names, and need no table library.
    import xarray as xr

#: Scalars per replicate that are words.
WORDS = tuple(name for name, row in SCALARS.items() if not row.unit)

#: Arrays besides scalars that a row may hold: profiles over the height, and those of its group.
ARRAYS = {n: row for n, row in variables_of("group", "profile").items() if row.in_datasets}

#: Their dimensions: heights differ between points, so that in a dataset they are over slices.
OF_PROFILES = {
    name: tuple("slice" if dimension == "height" else dimension for dimension in row.dims)
    for name, row in ARRAYS.items()
}

#: Path of the particles after the last sample, which animations need.
PATH_VARIABLES = ("path", "path_time")

#: Variables that figures of particles need: last state and path. No figure draws the others.
STATE_VARIABLES = (
    *(name for name in variables_of("particle") if name not in ("particle_spin", "orientation")),
    *PATH_VARIABLES,
)

#: Group of a dataset with one subgroup per point whose particles are stored.
PARTICLES = "states"

#: Group of a dataset with the origin of each row: its run file, and the variables of that file.
RUNS = "runs"

#: What is held in single precision: seven digits, of which statistics know three.
SINGLE = OF_PROFILES.keys() - {"height"}

#: Binary digits of scalars in datasets, a relative error of 6e-8; run files have all digits.
SCALAR_DIGITS = 24

#: Where the values of profiles lie in each of their dimensions.
CENTRES = {"slice": "height", "square": "column", "moment": "cycle_phase"}

#: What tells how long a run is in each dimension: it has neither NaN nor ``""`` of its own.
_LENGTHS = {"replicate": "status"} | CENTRES


def row_scalars(system: str | None = None) -> dict[str, Variable]:
    """Return the scalars per replicate that rows of a system, or of all, may hold, words last.

    They are those of run files, and observables.
    """
    rows = variables_of("scalar", system=system) | observable_variables(system)
    return dict(sorted(rows.items(), key=lambda row: row[0] in WORDS))


def row_arrays(system: str | None = None) -> list[str]:
    """Return the names of the arrays that rows of a system, or of all, may hold."""
    return [name for name, row in ARRAYS.items() if system in (None, *row.in_datasets)]


def dimensions(name: str) -> tuple[str, ...]:
    """Return the dimensions of what a row holds."""
    return OF_PROFILES.get(name, ("replicate",))


def reader_hash() -> str:
    """Return a hash of the code that reads run files; rows that other code has read are read again.

    The names and hashes of observables of plug-ins, if there are any, follow it.
    """
    return f"{_package_hash()} {codes(OBSERVABLE)}".rstrip()


@cache
def _package_hash() -> str:
    package = Path(__file__).parents[1]
    names = [Path(identity.__file__)]
    return f"{room_hash(package, 'dataset')} {files_hash(names)}"


def stored_names(system: str | None = None) -> set[str]:
    """Return the names of all variables that this code stores of a system, or of all systems."""
    names = {*row_scalars(system), *row_arrays(system), *STATE_VARIABLES}
    return names | measured_names(system)


def stored_particles(states: Mapping[str, Any], point: str) -> Shown:
    """Return how much of the particles of a point a dataset stores in its groups of states."""
    if point not in states:
        return Shown.NOTHING
    return Shown.PATH if "path" in states[point].variables else Shown.STATE


def points_with_profiles(file: Any) -> set[str]:
    """Return the points whose profiles a dataset, opened by netCDF4, has."""
    groups = [group for name, group in file.groups.items() if name in SYSTEMS]
    return {point for group in groups for point in group["run"][:].tolist()}


def amounts_text(amounts: Mapping[str, float] | None) -> str:
    """Return the amounts of a point as JSON; equal amounts give equal texts."""
    return json.dumps(dict(amounts or {}), sort_keys=True)


class Rows(NamedTuple):
    """Runs that hold the same variables, a row each.

    Attributes
    ----------
    points : list of str
        Ids of their points.
    origin : dict of str to list of str
        By name, what made each: ``seal`` of its file, how much of it was ``wanted``,
        ``engine_version``, ``numerics``,
        ``source_hash``, ``versions``, ``created``, the ``caveat`` it gives itself, and the name of
        the dataset that it was ``adopted`` with, if any.
    values : dict of str to array
        Scalars, measures and profiles, over rows and their `dimensions`.
    states : dict of str to xarray.Dataset
        Last state and path of the particles, by point, where a figure shows them.
    """

    points: list[str]
    origin: dict[str, list[str]]
    values: dict[str, np.ndarray]
    states: dict[str, "xr.Dataset"]


def merge_rows(blocks: Iterable[Rows]) -> list[Rows]:
    """Merge rows into one block for each set of variables."""
    groups: dict[tuple[str, ...], list[Rows]] = {}
    for block in blocks:
        groups.setdefault(tuple(block.values), []).append(block)
    return [_merge(group, names) for names, group in groups.items()]


def align_rows(
    blocks: Iterable[Rows], points: Sequence[str], names: Iterable[str], replicates: int = 0
) -> Rows:
    """Return the rows of points in one block, in the order of the points.

    Parameters
    ----------
    blocks : iterable of Rows
        Rows, among them one of each point.
    points : sequence of str
        Ids of the points.
    names : iterable of str
        Variables to return, where any row has them. The block is no longer than the longest run;
        NaN or ``""`` is where a run is shorter or lacks a variable.
    replicates : int
        Smallest number of replicates of the block.

    Returns
    -------
    Rows
        Its origin also has the names of all ``variables`` of each row.
    """
    blocks = [
        block._replace(
            origin=block.origin | {"variables": [" ".join(block.values)] * len(block.points)}
        )
        for block in select_rows(blocks, set(points))
    ]
    present = [name for name in names if any(name in block.values for block in blocks)]
    merged = _merge(blocks, present, replicates)
    rows = {point: row for row, point in enumerate(merged.points)}
    order = [rows[point] for point in points]
    return Rows(
        points=list(points),
        origin={name: [texts[row] for row in order] for name, texts in merged.origin.items()},
        values={name: array[order] for name, array in merged.values.items()},
        states=merged.states,
    )


def _merge(blocks: Sequence[Rows], names: Iterable[str], replicates: int = 0) -> Rows:
    """Return the rows of all blocks as one, with some of their variables."""
    sizes = {"replicate": replicates}
    for block in blocks:
        for name, values in block.values.items():
            for dimension, size in zip(dimensions(name), values.shape[1:], strict=True):
                sizes[dimension] = max(size, sizes.get(dimension, 0))
    return Rows(
        points=row_points(blocks),
        origin={
            name: list(chain.from_iterable(block.origin[name] for block in blocks))
            for name in blocks[0].origin
        },
        values={name: _stack(blocks, name, sizes) for name in names},
        states={point: state for block in blocks for point, state in block.states.items()},
    )


def select_rows(blocks: Iterable[Rows], points: Collection[str]) -> list[Rows]:
    """Return the rows of some points, no longer than the longest run of a block."""
    selection = []
    for block in blocks:
        rows = np.flatnonzero([point in points for point in block.points])
        if rows.size:
            places = slice(None) if rows.size == len(block.points) else rows
            values = {name: array[places] for name, array in block.values.items()}
            lengths = {
                dimension: int(_is_known(values[name]).any(axis=0).sum())
                for dimension, name in _LENGTHS.items()
                if name in values
            }
            cut = {
                name: array[:, *(slice(lengths.get(dimension)) for dimension in dimensions(name))]
                for name, array in values.items()
            }
            origin = {name: [texts[row] for row in rows] for name, texts in block.origin.items()}
            states = {point: state for point, state in block.states.items() if point in points}
            selection.append(Rows([block.points[row] for row in rows], origin, cut, states))
    return selection


def _is_known(values: np.ndarray) -> np.ndarray:
    return values != "" if values.dtype == object else np.isfinite(values)


def without_profiles(block: Rows) -> Rows:
    """Return rows without their profiles."""
    values = {name: array for name, array in block.values.items() if name not in OF_PROFILES}
    return block._replace(values=values)


def round_scalars(block: Rows) -> Rows:
    """Return rows with scalars of `SCALAR_DIGITS` binary digits.

    What a dataset computes of scalars is then the same whether they come from run files or from a
    dataset, which stores no more digits.
    """

    def rounded(values: np.ndarray) -> np.ndarray:
        mantissa, exponent = np.frexp(values)
        return np.ldexp(np.rint(np.ldexp(mantissa, SCALAR_DIGITS)), exponent - SCALAR_DIGITS)

    values = {
        name: rounded(array) if array.dtype == np.float64 and name not in OF_PROFILES else array
        for name, array in block.values.items()
    }
    return block._replace(values=values)


def row_points(blocks: Iterable[Rows]) -> list[str]:
    """Return the points of all rows."""
    return list(chain.from_iterable(block.points for block in blocks))


def _stack(blocks: Sequence[Rows], name: str, sizes: dict[str, int]) -> np.ndarray:
    """Return a variable of all rows, with NaN or ``""`` where a run is shorter or lacks it."""
    shape = (len(row_points(blocks)), *(sizes[dimension] for dimension in dimensions(name)))
    if name in WORDS:
        table = np.full(shape, "", object)
    else:
        table = np.full(shape, np.nan, np.float32 if name in SINGLE else float)
    first = 0
    for block in blocks:
        rows = slice(first, first := first + len(block.points))
        if name in block.values:
            values = block.values[name]
            table[(rows, *map(slice, values.shape[1:]))] = values
    return table
