"""Runs as rows of arrays: the variables of each row, and how rows are aligned."""

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sim.base.additions import codes
from sim.base.program import files_hash, room_hash
from sim.engine import identity
from sim.engine.stored_run import measured_codes
from sim.parameters.variables import (
    OBSERVABLE,
    SCALARS,
    Variable,
    observable_variables,
    variables_of,
)

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


def stored_names() -> set[str]:
    """Return the names of all variables that this code stores of any system."""
    return {*row_scalars(None), *row_arrays(None), *STATE_VARIABLES} | measured_codes(None)


def amounts_text(amounts: Mapping[str, float] | None) -> str:
    """Return the amounts of a point as JSON; equal amounts give equal texts."""
    return json.dumps(dict(amounts or {}), sort_keys=True)


class Row(NamedTuple):
    """A run in a dataset.

    It has the id of its ``point``; of its ``origin``, by name, what made it: ``seal`` of its file,
    how much of it was ``wanted``, ``engine_version``, ``numerics``, ``source_hash``, ``versions``,
    ``created``, the ``caveat`` it gives itself, and the name of the dataset that it was ``adopted``
    with, if any; as ``values`` scalars, measures and profiles, over their `dimensions`; and as
    ``state`` last state and path of the particles, where a figure shows them.
    """

    point: str
    origin: dict[str, str]
    values: dict[str, np.ndarray]
    state: "xr.Dataset | None" = None

    def without_padding(self) -> "Row":
        """Return the row without what a dataset has filled it up with to a longer one."""
        lengths = {
            dimension: int(_is_known(self.values[name]).sum())
            for dimension, name in _LENGTHS.items()
            if name in self.values
        }
        cut = {
            name: array[tuple(slice(lengths.get(dimension)) for dimension in dimensions(name))]
            for name, array in self.values.items()
        }
        return self._replace(values=cut)


class Table(NamedTuple):
    """Runs in one table: ``origin`` and ``values`` of `Row`, each over the points.

    ``origin`` also has the names of all ``variables`` of each row.
    """

    points: Sequence[str]
    origin: dict[str, list[str]]
    values: dict[str, np.ndarray]


def tabulate_rows(
    rows: Mapping[str, Row], points: Sequence[str], names: Iterable[str], replicates: int = 0
) -> Table:
    """Return the rows of points in one table, in the order of the points.

    The table has the variables of these ``names`` that any row has, and at least ``replicates``.
    They are as long as the longest run; NaN or ``""`` is where a run is shorter or lacks a
    variable.
    """
    chosen = [rows[point] for point in points]
    sizes = {"replicate": replicates}
    for row in chosen:
        for name, values in row.values.items():
            for dimension, size in zip(dimensions(name), values.shape, strict=True):
                sizes[dimension] = max(size, sizes.get(dimension, 0))
    origins = [row.origin | {"variables": " ".join(row.values)} for row in chosen]
    return Table(
        points=points,
        origin={name: [origin[name] for origin in origins] for name in origins[0]},
        values={
            name: _column(chosen, name, sizes)
            for name in names
            if any(name in row.values for row in chosen)
        },
    )


def _column(rows: Sequence[Row], name: str, sizes: Mapping[str, int]) -> np.ndarray:
    """Return a variable of all rows, with NaN or ``""`` where a run is shorter or lacks it.

    Scalars have `SCALAR_DIGITS` binary digits. What a dataset computes of them is then the same
    whether they come from run files or from a dataset, which stores no more digits.
    """
    shape = (len(rows), *(sizes[dimension] for dimension in dimensions(name)))
    if name in WORDS:
        table = np.full(shape, "", object)
    else:
        table = np.full(shape, np.nan, np.float32 if name in SINGLE else float)
    for place, row in zip(table, rows, strict=True):
        if name in row.values:
            place[tuple(map(slice, row.values[name].shape))] = row.values[name]
    if name in WORDS or name in OF_PROFILES:
        return table
    mantissa, exponent = np.frexp(table)
    return np.ldexp(np.rint(np.ldexp(mantissa, SCALAR_DIGITS)), exponent - SCALAR_DIGITS)


def _is_known(values: np.ndarray) -> np.ndarray:
    return values != "" if values.dtype == object else np.isfinite(values)
