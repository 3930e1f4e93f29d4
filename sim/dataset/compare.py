"""Two runs or two studies against each other, point by point, by what their replicates know."""

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
from sim.dataset.added import require_known_options
from sim.dataset.results import load
from sim.engine.stored_run import opened, parameters_of
from sim.parameters import AMOUNTS, SYSTEMS, complete, field_info

#: Share of false ones among the differences that are called real.
RISK = round(1 - CONFIDENCE, 12)

#: What a replicate knows of its own mean velocity, and of how many samples.
_OWN, _SAMPLES = "velocity_half_width", "independent_samples"

#: Parameters of which each side may have its own, and points are the same all the same.
_OWN_OF_SIDES = {*AMOUNTS, "seed", "threads"}


@dataclass(frozen=True)
class Mean:
    """A mean with its standard error and the degrees of freedom behind that."""

    value: float
    error: float
    freedom: float

    @property
    def half_width(self) -> float:
        """Half of its 95 % interval; not-a-number where the error is not known."""
        return float(student(self.freedom) * self.error) if self.freedom > 0 else np.nan


@dataclass(frozen=True)
class Measured:
    """A quantity of one point.

    Attributes
    ----------
    system : str
    parameters : mapping
        All of the point, by name.
    values : (R,) array
        Of the completed replicates.
    own, samples : (R,) array
        Half of the 95 % interval that each replicate knows by itself, and from how many samples;
        not-a-number where it does not.
    """

    system: str
    parameters: Mapping[str, Any]
    values: np.ndarray
    own: np.ndarray
    samples: np.ndarray

    @cached_property
    def mean(self) -> Mean:
        """Mean of the replicates with the error by their scatter, or by what each knows of itself:
        the larger of the two, as everywhere (`sim.base.statistics.mean_interval`)."""
        number, value = self.values.size, float(self.values.mean())
        half_width, _ = mean_interval(self.values, self.own)
        by_scatter = half_width == student_half_width(self.values)
        freedom = number - 1 if by_scatter else float(self.samples.sum()) - number
        if not freedom > 0:
            return Mean(value, np.nan, np.nan)
        return Mean(value, float(half_width / student(freedom)), freedom)


@dataclass(frozen=True)
class Pair:
    """A point of one side beside that of the other.

    ``key`` are the parameters that tell points apart, by name.
    """

    system: str
    key: Mapping[str, Any]
    first: Mean
    second: Mean

    @cached_property
    def difference(self) -> Mean:
        """The second less the first, with Welch's degrees of freedom."""
        value = self.second.value - self.first.value
        squares = self.first.error**2, self.second.error**2
        if sum(squares) == 0:
            return Mean(value, 0.0, MANY)
        parts = squares[0] ** 2 / self.first.freedom + squares[1] ** 2 / self.second.freedom
        return Mean(value, float(np.sqrt(sum(squares))), float(sum(squares) ** 2 / parts))

    @property
    def chance(self) -> float:
        """How often chance alone sets equal means so far apart (Welch's test).

        Not-a-number where an error is not known.
        """
        apart = self.difference
        if apart.error == 0:
            return float(apart.value == 0)
        return float(2 * t.sf(abs(apart.value) / apart.error, apart.freedom))


@dataclass(frozen=True)
class Comparison:
    """What two sides have in common and how far apart they are.

    Attributes
    ----------
    quantity, unit : str
    differ : mapping
        Parameters that are one value throughout the first side and another throughout the second,
        with both values.
    pairs : sequence of Pair
        In the order of the first side.
    alone : (int, int)
        Points of each side that the other does not have.
    shorter : (int, int)
        Points of each side that are left out, as another differs from them only in how much was
        run and has more.
    """

    quantity: str
    unit: str
    differ: Mapping[str, tuple[Any, Any]]
    pairs: Sequence[Pair]
    alone: tuple[int, int]
    shorter: tuple[int, int]

    @cached_property
    def real(self) -> list[bool]:
        """Which pairs differ by more than chance: 5 % of those at most are false (Benjamini)."""
        chances = np.array([pair.chance for pair in self.pairs])
        known = np.isfinite(chances)
        found = np.zeros(len(chances), bool)
        if known.any():
            found[known] = false_discovery_control(chances[known]) <= RISK
        return found.tolist()


def read_measured(path: Path, quantity: str) -> tuple[list[Measured], str]:
    """Return a quantity of every completed point of a side, and its unit.

    Parameters
    ----------
    path : Path
        A run file, a dataset, or the folder of a study's results.
    quantity : str
        Anything that the side has over its replicates, as ``velocity``.

    Raises
    ------
    InputError
        When there is no such file, or it has no such quantity, or none that is known.
    """
    is_study = path.is_dir() or path.name == "dataset.nc"
    found, unit = (_of_study if is_study else _of_run)(path, quantity)
    if not found:
        raise InputError(f"{path}: no completed run knows its {quantity}: nothing to compare")
    return found, unit


def _of_run(path: Path, quantity: str) -> tuple[list[Measured], str]:
    with opened(path) as file:
        point = parameters_of(file, path)
        _require(quantity, path, [n for n, one in file.variables.items() if _is_number(one)])
        done = file["status"][:] == "completed"
        columns = [np.asarray(file[name][:], float)[done] for name in (quantity, _OWN, _SAMPLES)]
        unit = file[quantity].units
    return _measured(point.system, complete(point), quantity, columns), unit


def _is_number(variable: netCDF4.Variable) -> bool:
    return variable.dimensions == ("replicate",) and variable.dtype is not str


def _of_study(path: Path, quantity: str) -> tuple[list[Measured], str]:
    held = load(path).dataset
    require_known_options(held, path)
    over = [
        str(name)
        for name, one in held.data_vars.items()
        if one.dims == ("point", "replicate") and one.dtype.kind == "f"
    ]
    _require(quantity, path, over)
    found = []
    for number, system in enumerate(held["system"].values):
        row = held.isel(point=number)
        done = row["status"].values == "completed"
        columns = [row[name].values[done] for name in (quantity, _OWN, _SAMPLES)]
        parameters = {name: row[name].item() for name in SYSTEMS[system].model_fields}
        found += _measured(str(system), parameters, quantity, columns)
    return found, held[quantity].attrs.get("units", "1")


def _require(quantity: str, path: Path, known: Collection[str]) -> None:
    if quantity not in known:
        raise InputError.of_value(str(path), "", quantity, "one of " + ", ".join(known))


def _measured(
    system: str, parameters: Mapping[str, Any], quantity: str, columns: Sequence[np.ndarray]
) -> list[Measured]:
    """Return a point's quantity, nothing where no replicate knows it."""
    values, own, samples = columns
    known = np.isfinite(values)
    if not known.any():
        return []
    if quantity != "velocity":
        own = np.full_like(own, np.nan)
        samples = own
    return [Measured(system, parameters, values[known], own[known], samples[known])]


def compare(
    first: Sequence[Measured],
    second: Sequence[Measured],
    quantity: str,
    unit: str,
    ignored: Collection[str] = (),
) -> Comparison:
    """Return two sides beside each other, paired by all parameters that vary within either.

    Parameters that are constant within each may differ: they are what is compared. So are those
    that are ``ignored``, as one that follows from another.

    Raises
    ------
    InputError
        When no point of the one is a point of the other, or when several would be.
    """
    sides = first, second
    systems = {one.system for side in sides for one in side}
    varying = {system: _varying(sides, system, ignored) for system in systems}
    keyed = [_keyed(side, varying) for side in sides]
    both = [key for key in keyed[0] if key in keyed[1]]
    if not both:
        raise InputError("no point of the one is a point of the other: nothing to compare")
    pairs = [
        Pair(
            key[0],
            dict(zip(varying[key[0]], key[1:], strict=True)),
            keyed[0][key].mean,
            keyed[1][key].mean,
        )
        for key in both
    ]
    alone = len(keyed[0]) - len(both), len(keyed[1]) - len(both)
    shorter = len(first) - len(keyed[0]), len(second) - len(keyed[1])
    return Comparison(quantity, unit, _differ(sides, varying), pairs, alone, shorter)


def _keyed(
    side: Sequence[Measured], varying: Mapping[str, Sequence[str]]
) -> dict[tuple[Any, ...], Measured]:
    """Return the points of a side by system and the parameters that vary.

    Of two that differ in how much was run, that with more replicates.
    """
    found: dict[tuple[Any, ...], Measured] = {}
    for one in side:
        key = one.system, *(one.parameters[name] for name in varying[one.system])
        other = found.setdefault(key, one)
        apart = {name for name, value in one.parameters.items() if other.parameters[name] != value}
        if apart - set(AMOUNTS):
            told = ", ".join(sorted(apart))
            raise InputError(f"several points of one side differ in nothing but {told}")
        if one.values.size > other.values.size:
            found[key] = one
    return found


def _varying(
    sides: Sequence[Sequence[Measured]], system: str, ignored: Collection[str]
) -> list[str]:
    """Return the parameters of a system that vary within a side."""
    rows = [[one.parameters for one in side if one.system == system] for side in sides]
    return [
        name
        for name in field_info(SYSTEMS[system])
        if name not in {*AMOUNTS, *ignored}
        and any(len({row[name] for row in side}) > 1 for side in rows)
    ]


def _differ(
    sides: Sequence[Sequence[Measured]], varying: Mapping[str, Collection[str]]
) -> dict[str, tuple[Any, Any]]:
    found = {}
    for system, names in varying.items():
        rows = [[one.parameters for one in side if one.system == system] for side in sides]
        if all(rows):
            for name in field_info(SYSTEMS[system]):
                values = tuple(side[0][name] for side in rows)
                if name not in {*names, *_OWN_OF_SIDES} and values[0] != values[1]:
                    found[name] = values
    return found
