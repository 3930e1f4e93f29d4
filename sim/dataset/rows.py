"""Runs as rows of arrays: the variables of each row, and how rows are aligned."""

from collections.abc import Collection, Iterable, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from sim.parameters.variables import SCALARS, Variable, observable_variables, variables_of

#: Scalars per replicate that are words.
WORDS = tuple(name for name, row in SCALARS.items() if not row.unit)

#: Arrays besides scalars that a row may hold: profiles over the height, and those of its group.
ARRAYS = {n: row for n, row in variables_of("group", "profile").items() if row.in_datasets}

#: Their dimensions: heights differ between points, so that in a dataset they are over slices.
OF_PROFILES = {
    name: tuple("slice" if dimension == "height" else dimension for dimension in row.dims)
    for name, row in ARRAYS.items()
}

#: What is held in single precision: seven digits, of which statistics know three.
SINGLE = OF_PROFILES.keys() - {"height"}

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
    states: dict[str, xr.Dataset]


def merge_rows(blocks: Iterable[Rows]) -> list[Rows]:
    """Merge rows into one block for each set of variables."""
    groups: dict[tuple[str, ...], list[Rows]] = {}
    for block in blocks:
        groups.setdefault(tuple(block.values), []).append(block)
    merged = []
    for names, group in groups.items():
        sizes = largest_sizes(group)
        texts = {name: [block.origin[name] for block in group] for name in group[0].origin}
        merged.append(
            Rows(
                points=row_points(group),
                origin={name: list(chain.from_iterable(parts)) for name, parts in texts.items()},
                values={name: align_rows(group, name, sizes) for name in names},
                states={point: state for block in group for point, state in block.states.items()},
            )
        )
    return merged


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


def row_points(blocks: Iterable[Rows]) -> list[str]:
    """Return the points of all rows."""
    return list(chain.from_iterable(block.points for block in blocks))


def origin_table(blocks: Iterable[Rows]) -> pd.DataFrame:
    """Return the origin of all rows, and the names of their ``variables``."""
    frames = (
        pd.DataFrame(block.origin, dtype=object).assign(variables=" ".join(block.values))
        for block in blocks
    )
    return pd.concat(frames, ignore_index=True)


def largest_sizes(blocks: Iterable[Rows]) -> dict[str, int]:
    """Return the largest size of each dimension."""
    sizes: dict[str, int] = {}
    for block in blocks:
        for name, values in block.values.items():
            for dimension, size in zip(dimensions(name), values.shape[1:], strict=True):
                sizes[dimension] = max(size, sizes.get(dimension, 0))
    return sizes


def align_rows(blocks: Sequence[Rows], name: str, sizes: dict[str, int]) -> np.ndarray:
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
