"""Compare two runs or two studies point by point, with the errors of their replicates."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import false_discovery_control, t

from sim.base.errors import InputError
from sim.base.messages import one_of
from sim.base.statistics import CONFIDENCE, MANY, mean_interval, student, student_half_width
from sim.dataset.results import load_results, require_known_options
from sim.engine.stored_run import open_run_file, parameters_of
from sim.parameters import AMOUNTS, SYSTEMS, complete_values, field_info

#: Share of false positives among the differences that are called real.
RISK = round(1 - CONFIDENCE, 12)

#: Scalars: half width of the mean velocity of a replicate, and its number of samples.
_HALF_WIDTH, _SAMPLES = "velocity_half_width", "independent_samples"

#: Parameters that may differ between two points that count as the same.
_SIDE_PARAMETERS = {*AMOUNTS, "seed", "threads"}


@dataclass(frozen=True)
class Mean:
    """A mean over replicates with its standard error and the degrees of freedom of the error.

    Error and freedom are not-a-number where they are not known.
    """

    value: float
    error: float
    freedom: float

    @property
    def half_width(self) -> float:
        """Half width of the 95 % interval; not-a-number where the error is not known."""
        return float(student(self.freedom) * self.error) if self.freedom > 0 else np.nan


def mean_of(values: np.ndarray, half_widths: np.ndarray, samples: np.ndarray) -> Mean:
    """Return the mean of replicates.

    Its error is the larger of two: that from their scatter, and that from their own intervals, as
    everywhere (`sim.base.statistics.mean_interval`). Each has its value, the half width of the 95 %
    interval within it, and its number of samples, (R,); not-a-number where the replicate has none.
    """
    value, (half_width, _) = float(values.mean()), mean_interval(values, half_widths)
    is_from_scatter = half_width == student_half_width(values)
    freedom = values.size - 1 if is_from_scatter else float(samples.sum()) - values.size
    if not freedom > 0:
        return Mean(value, np.nan, np.nan)
    return Mean(value, float(half_width / student(freedom)), freedom)


@dataclass(frozen=True)
class Pair:
    """A point of the first side and the same point of the second.

    ``key`` has the parameters that tell points apart, by name.
    """

    system: str
    key: Mapping[str, Any]
    first: Mean
    second: Mean

    @cached_property
    def difference(self) -> Mean:
        """The second mean minus the first, with Welch's degrees of freedom."""
        value = self.second.value - self.first.value
        squares = self.first.error**2, self.second.error**2
        if sum(squares) == 0:
            return Mean(value, 0.0, MANY)
        parts = squares[0] ** 2 / self.first.freedom + squares[1] ** 2 / self.second.freedom
        return Mean(value, float(np.sqrt(sum(squares))), float(sum(squares) ** 2 / parts))

    @property
    def chance(self) -> float:
        """Return the p-value of Welch's test: how often equal means differ this much by chance.

        Not-a-number where an error is not known.
        """
        difference = self.difference
        if difference.error == 0:
            return float(difference.value == 0)
        return float(2 * t.sf(abs(difference.value) / difference.error, difference.freedom))


@dataclass(frozen=True)
class Comparison:
    """Comparison of two sides: their common points and their differences.

    ``pairs`` are in the order of the first side. ``differing_parameters`` have one value throughout
    the first side and another throughout the second; both are given. ``unmatched_counts`` are the
    numbers of points of each side that the other does not have, and ``shorter_counts`` of those
    left out, because another point differs from them only in its amounts and has more replicates.
    """

    pairs: Sequence[Pair]
    differing_parameters: Mapping[str, tuple[Any, Any]]
    unmatched_counts: tuple[int, int]
    shorter_counts: tuple[int, int]

    @cached_property
    def is_real(self) -> list[bool]:
        """Per pair: does it differ by more than chance? At most 5 % are false (Benjamini)."""
        chances = np.array([pair.chance for pair in self.pairs])
        is_known = np.isfinite(chances)
        is_real = np.zeros(len(chances), bool)
        if is_known.any():
            is_real[is_known] = false_discovery_control(chances[is_known]) <= RISK
        return is_real.tolist()


def read_side(path: Path, quantity: str) -> tuple[pd.DataFrame, str]:
    """Return a table of the points of a side, and the unit of a quantity.

    The side is a run file, a dataset, or the folder of a study's results; the quantity any number
    that it has per replicate, such as ``velocity``. For the table, of points with a known value,
    see `tabulate`. Raises `InputError` when there is no such file, or it has no such quantity, or
    no completed run has a value.
    """
    names = (quantity, _HALF_WIDTH, _SAMPLES)
    rows: list[tuple[dict[str, Any], list[np.ndarray]]] = []
    if path.is_dir() or path.name == "dataset.nc":
        dataset = load_results(path).dataset
        require_known_options(dataset, path)
        kinds = {str(name): (one.dims, one.dtype.kind) for name, one in dataset.items()}
        quantities = [name for name, kind in kinds.items() if kind == (("point", "replicate"), "f")]
        _require_quantity(quantity, path, quantities)
        unit = dataset[quantity].attrs.get("units", "1")
        for number, system in enumerate(dataset["system"].values):
            row = dataset.isel(point=number)
            parameters = {name: row[name].item() for name in SYSTEMS[system].model_fields}
            is_done = row["status"].values == "completed"
            rows.append((parameters, [row[name].values[is_done] for name in names]))
    else:
        with open_run_file(path) as file:
            kinds = {name: (one.dimensions, one.dtype) for name, one in file.variables.items()}
            quantities = [
                name
                for name, (dims, kind) in kinds.items()
                if dims == ("replicate",) and kind is not str
            ]
            _require_quantity(quantity, path, quantities)
            unit, is_done = file[quantity].units, file["status"][:] == "completed"
            columns = [np.asarray(file[name][:], float)[is_done] for name in names]
            rows.append((complete_values(parameters_of(file, path)), columns))
    table = tabulate(rows, quantity)
    if table.empty:
        raise InputError(f"{path}: no completed run knows its {quantity}: nothing to compare")
    return table, unit


def _require_quantity(quantity: str, path: Path, allowed: Collection[str]) -> None:
    if quantity not in allowed:
        raise InputError.of_value(str(path), "", quantity, one_of(quantity, allowed))


def tabulate(
    rows: Iterable[tuple[Mapping[str, Any], Sequence[np.ndarray]]], quantity: str
) -> pd.DataFrame:
    """Return a table with a row for each point with a known value.

    ``rows`` have the parameters of each point, and the arguments of `mean_of` over its completed
    replicates; the intervals within runs are those of ``velocity`` and of no other quantity.
    Columns are all parameters, ``system`` among them; ``_mean``, a `Mean`; and ``_replicates``.
    """
    table = []
    for parameters, columns in rows:
        values, half_widths, samples = (column[np.isfinite(columns[0])] for column in columns)
        if values.size:
            if quantity != "velocity":
                half_widths = samples = np.full(values.size, np.nan)
            mean = mean_of(values, half_widths, samples)
            table.append({**parameters, "_mean": mean, "_replicates": values.size})
    # Objects compare as in Python: a dataset stores as numbers what a run file knows to be true.
    return pd.DataFrame(table, dtype=object)


def compare(first: pd.DataFrame, second: pd.DataFrame, ignored: Collection[str] = ()) -> Comparison:
    """Return the comparison of two sides, paired by all parameters that vary within either.

    Parameters that are constant within each side may differ between them: they are compared.
    ``ignored`` parameters may differ too, for example one that follows from another. Raises
    `InputError` when the sides have no point in common, or when several points of a side are paired
    with one.
    """
    # Either side may lack a system, and so its parameters.
    columns = list(dict.fromkeys([*first, *second]))
    first, second = (side.reindex(columns=columns) for side in (first, second))
    pairs: dict[int, Pair] = {}
    differing: dict[str, tuple[Any, Any]] = {}
    counts = np.zeros(2, int)
    for system in dict.fromkeys([*first["system"], *second["system"]]):
        names = [name for name in field_info(SYSTEMS[system]) if name not in AMOUNTS]
        sides = [side[side["system"] == system] for side in (first, second)]
        varying = [
            name
            for name in names
            if name not in ignored and any(side[name].nunique() > 1 for side in sides)
        ]
        sides = [_longest(side, varying, [*set(names) & set(ignored)]) for side in sides]
        counts += [len(side) for side in sides]
        merged = sides[0].merge(sides[1], on=["system", *varying])
        for row in merged.to_dict("records"):
            key = {name: row[name] for name in varying}
            pairs[row["_place_x"]] = Pair(system, key, row["_mean_x"], row["_mean_y"])
        for name in names if all(len(side) for side in sides) else ():
            values = tuple(side[name].tolist()[0] for side in sides)
            if name not in {*varying, *_SIDE_PARAMETERS} and values[0] != values[1]:
                differing[name] = values
    if not pairs:
        raise InputError("the two have no point in common: nothing to compare")
    unmatched, shorter = counts - len(pairs), [len(first), len(second)] - counts
    return Comparison(
        [pairs[place] for place in sorted(pairs)],
        differing,
        (int(unmatched[0]), int(unmatched[1])),
        (int(shorter[0]), int(shorter[1])),
    )


def _longest(side: pd.DataFrame, varying: Sequence[str], ignored: Sequence[str]) -> pd.DataFrame:
    """Return the points of a side without those that another has with more replicates.

    Column ``_place`` is the number of the first of them in the side. Points that differ in an
    ignored parameter are refused.
    """
    keys = ["system", *varying]
    groups = side.groupby(keys, sort=False)
    if differing := sorted(name for name in ignored if (groups[name].nunique() > 1).any()):
        raise InputError(f"several points of one side differ in nothing but {', '.join(differing)}")
    places = side.assign(_place=side.index).groupby(keys)["_place"].transform("min")
    order = side.assign(_place=places).sort_values("_replicates", ascending=False, kind="stable")
    return order.drop_duplicates(keys).sort_values("_place")
