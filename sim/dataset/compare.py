"""Compare two runs or two studies point by point, with the errors of their replicates."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from scipy.stats import false_discovery_control, t

from sim.base.errors import InputError
from sim.base.statistics import CONFIDENCE, MANY, mean_interval, student, student_half_width
from sim.dataset.results import load, require_known_options
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
    """A mean with its standard error and the degrees of freedom of the error."""

    value: float
    error: float
    freedom: float

    @property
    def half_width(self) -> float:
        """Half width of the 95 % interval; not-a-number where the error is not known."""
        return float(student(self.freedom) * self.error) if self.freedom > 0 else np.nan


@dataclass(frozen=True)
class PointValues:
    """A quantity of one point, per completed replicate.

    Attributes
    ----------
    system : str
    parameters : mapping
        All parameters of the point, by name.
    values : (R,) array
        The quantity of each completed replicate.
    half_widths, samples : (R,) array
        Half width of the 95 % interval within each replicate, and its number of samples;
        not-a-number where the replicate has none.
    """

    system: str
    parameters: Mapping[str, Any]
    values: np.ndarray
    half_widths: np.ndarray
    samples: np.ndarray

    @cached_property
    def mean(self) -> Mean:
        """Mean of the replicates. Its error is the larger of two: that from their scatter, and that
        from their own intervals, as everywhere (`sim.base.statistics.mean_interval`)."""
        number, value = self.values.size, float(self.values.mean())
        half_width, _ = mean_interval(self.values, self.half_widths)
        is_from_scatter = half_width == student_half_width(self.values)
        freedom = number - 1 if is_from_scatter else float(self.samples.sum()) - number
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

    Attributes
    ----------
    quantity, unit : str
    differing_parameters : mapping
        Parameters with one value throughout the first side and another throughout the second, with
        the two values.
    pairs : sequence of Pair
        In the order of the first side.
    unmatched_counts : (int, int)
        Numbers of points of each side that the other does not have.
    shorter_counts : (int, int)
        Numbers of points of each side that are left out, because another point differs from them
        only in its amounts and has more replicates.
    """

    quantity: str
    unit: str
    differing_parameters: Mapping[str, tuple[Any, Any]]
    pairs: Sequence[Pair]
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


def read_values(path: Path, quantity: str) -> tuple[list[PointValues], str]:
    """Return a quantity of every completed point of a side, and its unit.

    Parameters
    ----------
    path : Path
        A run file, a dataset, or the folder of a study's results.
    quantity : str
        Any number that the side has per replicate, such as ``velocity``.

    Raises
    ------
    InputError
        When there is no such file, or it has no such quantity, or no completed run has a value.
    """
    is_study = path.is_dir() or path.name == "dataset.nc"
    points, unit = (_study_values if is_study else _run_values)(path, quantity)
    if not points:
        raise InputError(f"{path}: no completed run knows its {quantity}: nothing to compare")
    return points, unit


def _run_values(path: Path, quantity: str) -> tuple[list[PointValues], str]:
    with open_run_file(path) as file:
        point = parameters_of(file, path)
        names = [name for name, variable in file.variables.items() if _is_number(variable)]
        _require_quantity(quantity, path, names)
        done = file["status"][:] == "completed"
        columns = [
            np.asarray(file[name][:], float)[done] for name in (quantity, _HALF_WIDTH, _SAMPLES)
        ]
        unit = file[quantity].units
    return _point_values(point.system, complete_values(point), quantity, columns), unit


def _is_number(variable: netCDF4.Variable) -> bool:
    return variable.dimensions == ("replicate",) and variable.dtype is not str


def _study_values(path: Path, quantity: str) -> tuple[list[PointValues], str]:
    dataset = load(path).dataset
    require_known_options(dataset, path)
    quantities = [
        str(name)
        for name, variable in dataset.data_vars.items()
        if variable.dims == ("point", "replicate") and variable.dtype.kind == "f"
    ]
    _require_quantity(quantity, path, quantities)
    points = []
    for number, system in enumerate(dataset["system"].values):
        row = dataset.isel(point=number)
        done = row["status"].values == "completed"
        columns = [row[name].values[done] for name in (quantity, _HALF_WIDTH, _SAMPLES)]
        parameters = {name: row[name].item() for name in SYSTEMS[system].model_fields}
        points += _point_values(str(system), parameters, quantity, columns)
    return points, dataset[quantity].attrs.get("units", "1")


def _require_quantity(quantity: str, path: Path, allowed: Collection[str]) -> None:
    if quantity not in allowed:
        raise InputError.of_value(str(path), "", quantity, "one of " + ", ".join(allowed))


def _point_values(
    system: str, parameters: Mapping[str, Any], quantity: str, columns: Sequence[np.ndarray]
) -> list[PointValues]:
    """Return a list with the quantity of a point, empty where no replicate has a value."""
    values, half_widths, samples = columns
    is_known = np.isfinite(values)
    if not is_known.any():
        return []
    if quantity != "velocity":
        half_widths = np.full_like(half_widths, np.nan)
        samples = half_widths
    arrays = (column[is_known] for column in (values, half_widths, samples))
    return [PointValues(system, parameters, *arrays)]


def compare(
    first: Sequence[PointValues],
    second: Sequence[PointValues],
    quantity: str,
    unit: str,
    ignored: Collection[str] = (),
) -> Comparison:
    """Return the comparison of two sides, paired by all parameters that vary within either.

    Parameters that are constant within each side may differ between them: they are compared.
    ``ignored`` parameters may differ too, for example one that follows from another.

    Raises
    ------
    InputError
        When the sides have no point in common, or when several points of a side are paired with
        one.
    """
    sides = first, second
    systems = {point.system for side in sides for point in side}
    varying = {system: _varying_parameters(sides, system, ignored) for system in systems}
    keyed = [_values_by_key(side, varying) for side in sides]
    common = [key for key in keyed[0] if key in keyed[1]]
    if not common:
        raise InputError("no point of the one is a point of the other: nothing to compare")
    pairs = [
        Pair(
            key[0],
            dict(zip(varying[key[0]], key[1:], strict=True)),
            keyed[0][key].mean,
            keyed[1][key].mean,
        )
        for key in common
    ]
    unmatched_counts = len(keyed[0]) - len(common), len(keyed[1]) - len(common)
    shorter_counts = len(first) - len(keyed[0]), len(second) - len(keyed[1])
    return Comparison(
        quantity,
        unit,
        _differing_parameters(sides, varying),
        pairs,
        unmatched_counts,
        shorter_counts,
    )


def _values_by_key(
    side: Sequence[PointValues], varying: Mapping[str, Sequence[str]]
) -> dict[tuple[Any, ...], PointValues]:
    """Return the points of a side by their system and their varying parameters.

    Of points that differ only in their amounts, that with most replicates is returned.
    """
    points: dict[tuple[Any, ...], PointValues] = {}
    for point in side:
        key = point.system, *(point.parameters[name] for name in varying[point.system])
        other = points.setdefault(key, point)
        differing = {
            name for name, value in point.parameters.items() if other.parameters[name] != value
        }
        if differing - set(AMOUNTS):
            names = ", ".join(sorted(differing))
            raise InputError(f"several points of one side differ in nothing but {names}")
        if point.values.size > other.values.size:
            points[key] = point
    return points


def _varying_parameters(
    sides: Sequence[Sequence[PointValues]], system: str, ignored: Collection[str]
) -> list[str]:
    """Return the parameters of a system that vary within a side."""
    rows = [[point.parameters for point in side if point.system == system] for side in sides]
    return [
        name
        for name in field_info(SYSTEMS[system])
        if name not in {*AMOUNTS, *ignored}
        and any(len({row[name] for row in side}) > 1 for side in rows)
    ]


def _differing_parameters(
    sides: Sequence[Sequence[PointValues]], varying: Mapping[str, Collection[str]]
) -> dict[str, tuple[Any, Any]]:
    differing = {}
    for system, names in varying.items():
        rows = [[point.parameters for point in side if point.system == system] for side in sides]
        if all(rows):
            for name in field_info(SYSTEMS[system]):
                values = tuple(side[0][name] for side in rows)
                if name not in {*names, *_SIDE_PARAMETERS} and values[0] != values[1]:
                    differing[name] = values
    return differing
