"""Entries under ``design`` of a series: points spread over ranges of its parameters."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial
from math import log2
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from sim.base.errors import InputError
from sim.base.messages import allowed_values
from sim.parameters import AMOUNTS, Parameters, canonical_number
from sim.parameters.common import TWO_NUMBERS, Real, broken_rule
from sim.parameters.in_place import OF_UNIT_SIZE, given_by, plain_number
from sim.parameters.roles import Declaration
from sim.study.design import OPERATORS, Axis, axis_of, block_size, read_comparison, unit_points
from sim.study.entries import Lists, Strict, optional

#: Points of a sequence that are looked at before `where` may be given up, and the share of them
#: that must satisfy it.
_MIN_DRAWN, _MIN_SHARE = 2**16, 1e-3

ALLOWED_VALUES = f"{TWO_NUMBERS}; {{between, scale}}, {{mean, deviation, between}} or {{choices}}"
_ALLOWED_CHOICES = "a list of two different values or more"
_ALLOWED_COMPARISON = (
    f"two sides with one of {' '.join(OPERATORS)} between, numbers or parameters under over that "
    "take numbers"
)

#: Keys in place of parameters that a design may spread: each gives one parameter, in proportion.
SPREAD = ("density",)

#: Largest deviation of a normal distribution, in ranges: what is wider cannot be told from even.
MOST_RANGES = 1000.0

#: Keys that a distribution may have together.
_KEYS = "between", "between scale", "between deviation mean", "choices"


class Distribution(Strict):
    """How the values of a parameter are spread: between two numbers, or over choices."""

    between: list[Real] = optional(
        "lowest and highest value", {"allowed": TWO_NUMBERS}, min_length=2, max_length=2
    )
    scale: Literal["linear", "log"] = Field(
        "linear", description="whether values or their logarithms are evenly spread between"
    )
    mean: Real = optional("mean of a normal distribution, which between cuts off")
    deviation: Real = optional("standard deviation of that distribution", gt=0)
    choices: list[Any] = optional(
        "the values, each equally often", {"allowed": _ALLOWED_CHOICES}, min_length=2
    )

    def require_rules(self) -> None:
        given = self.model_dump(exclude_unset=True)
        if " ".join(sorted(given)) not in _KEYS:
            raise broken_rule("", given, ALLOWED_VALUES)
        if self.between:
            low, high = self.between
            self.require("between", low < high, TWO_NUMBERS)
            is_possible = self.scale != "log" or low > 0
            self.require("between", is_possible, "two numbers > 0 where the scale is log")
            is_within = self.mean is None or low <= self.mean <= high
            self.require("mean", is_within, f"a number in [{low:g}, {high:g}], as of between")
            is_narrow = self.deviation is None or self.deviation <= MOST_RANGES * (high - low)
            allowed = f"a number <= {MOST_RANGES:g} times the range; what is wider is even"
            self.require("deviation", is_narrow, allowed)
        choices = self.choices or []
        are_values = all(isinstance(value, bool | int | float | str) for value in choices)
        different = {str(canonical_number(value)) for value in choices}
        is_list = are_values and len(different) == len(choices)
        self.require("choices", is_list, _ALLOWED_CHOICES)

    def axis(self, name: str, is_integer: bool) -> Axis:
        """Return the axis of a parameter that is spread like this."""
        if self.choices:
            axis = axis_of(name, self.choices, is_integer)
            return replace(axis, choices=tuple(self.choices))
        normal = None if self.mean is None else (self.mean, self.deviation)
        low, high = self.between
        return Axis(name, low, high, self.scale, normal=normal, is_integer=is_integer)


def read_values(value: Any, row: Declaration) -> Any:
    """Return what a mapping says of the values of a parameter, ``row``; a list stays one."""
    given = list(value.values()) if isinstance(value, dict) else value
    plain = plain_number(given, row, {})
    if plain != plain_number(plain, row, OF_UNIT_SIZE):
        raise broken_rule("", value, f"numbers in {row.scale} without a unit: sizes may differ")
    value = dict(zip(value, plain, strict=True)) if isinstance(value, dict) else plain
    if isinstance(value, dict):
        return Distribution.model_validate(value)
    if not isinstance(value, list) or not value:
        raise broken_rule("", value, ALLOWED_VALUES)
    return value


def distribution(values: Any) -> Distribution:
    """Return how values are spread that `read_values` gives: a list has the lowest and highest."""
    return Distribution(between=values) if isinstance(values, list) else values


class Over(Lists):
    """Values of the parameters of a design."""

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return a hint at the intended key, empty if there is none."""
        if key in AMOUNTS:
            return f"{key} belongs under base, as it makes no other point"
        if key in cls.in_place:
            names = " and ".join(given_by(cls.parameters, key))
            return f"a design spreads parameters: {names} in place of {key}"
        return super().hint(key, value)


class DesignFile(Strict):
    """Points that are spread over ranges of parameters, in place of a grid."""

    #: What `expand` adds. Function: values by parameter → parameters of the point there, under the
    #: first reading; study file and key of the design, for messages.
    parameters_at: ClassVar[Any]
    place: ClassVar[tuple[str, str]]

    kind: Literal["sobol", "latin_hypercube", "random", "zip", "saltelli", "morris"] = Field(
        description="how points are spread: `sobol` evenly, `latin_hypercube` evenly along each "
        "parameter, `random`; `zip` pairs lists; `saltelli` and `morris` for sensitivity"
    )
    points: int = optional("number of points (of zip, the lists give it)", ge=1)
    seed: int = Field(1, description="seed of the points", ge=0, le=2**32 - 1)
    over: Over = Field(
        description="the parameters that vary: `[lowest, highest]`, `{between, scale: log}`, "
        "`{mean, deviation, between}`, `{choices}`; of zip lists of equal length"
    )
    where: list[str] = optional(
        "conditions that all points satisfy, as `friction < restitution` (sobol, random, zip)",
        min_length=1,
    )

    def require_rules(self) -> None:
        self._require_values()
        self._require_number()
        is_possible = not self.where or self.kind in ("sobol", "random", "zip")
        self.require("where", is_possible, f"none with {self.kind}, whose points belong together")
        numeric = {axis.name for axis in self.axes if axis.is_number}
        for index, text in enumerate(self.where or []):
            comparison = read_comparison(text)
            if not comparison or not comparison.names or not numeric.issuperset(comparison.names):
                raise broken_rule(f"where[{index}]", text, _ALLOWED_COMPARISON)

    def _require_values(self) -> None:
        values = self._values
        first = next(iter(values))
        for name, given in values.items():
            if self.kind != "zip":
                spread = self._distribution(name)
                self._require_allowed(name, spread.choices or spread.between)
            elif not isinstance(given, list):
                got = given.model_dump(exclude_unset=True)
                raise broken_rule(f"over.{name}", got, "a list of values, as kind is zip")
            elif len(given) != (wanted := len(values[first])):
                raise broken_rule(f"over.{name}", given, f"{wanted} values, as {first} has")
            else:
                self._require_allowed(name, given)

    def _require_allowed(self, name: str, values: Iterable[Any]) -> None:
        field = self._field(name)
        kind: Any = Annotated[(field.annotation, *field.metadata, None)]
        adapter = TypeAdapter(kind, config=ConfigDict(strict=True, allow_inf_nan=False))
        for value in values:
            if field.annotation is int and isinstance(value, float) and value.is_integer():
                value = int(value)
            try:
                adapter.validate_python(value)
            except ValidationError:
                raise broken_rule(f"over.{name}", value, allowed_values(field)) from None

    def _require_number(self) -> None:
        if self.kind == "zip":
            self.require("points", self.points is None, "none, as the lists of zip say how many")
            return
        self.require("points", self.points, "an integer >= 1")
        block = block_size(self.kind, len(self._values))
        blocks = max(2, self.points // block)
        match self.kind:
            case "saltelli":
                blocks = 2 ** int(log2(blocks))
                fitting, factor = (blocks * block, 2 * blocks * block), "a power of two"
            case "morris":
                fitting, factor = (blocks * block, (blocks + 1) * block), "two or more"
            case _:
                return
        allowed = f"{fitting[0]:,} or {fitting[1]:,}, as {block} times {factor}"
        self.require("points", self.points in fitting, allowed)

    @property
    def _values(self) -> dict[str, Any]:
        return {name: values for name, values in self.over if values is not None}

    def _distribution(self, name: str) -> Distribution:
        try:
            return distribution(self._values[name])
        except ValidationError:
            raise broken_rule(f"over.{name}", self._values[name], ALLOWED_VALUES) from None

    def _field(self, name: str) -> FieldInfo:
        return (self.over.parameters.model_fields | self.over.in_place)[name]

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The parameters that it varies, in the order of the reference."""
        axes = []
        for name, values in self._values.items():
            spread = partial(axis_of, values=values)
            make = spread if self.kind == "zip" else self._distribution(name).axis
            axes.append(make(name, is_integer=self._field(name).annotation is int))
        return tuple(axes)

    @property
    def max_points(self) -> int:
        """Number of points, those of zip that do not satisfy ``where`` included."""
        return self.points or len(next(iter(self._values.values())))

    @cached_property
    def size(self) -> int:
        """Number of its points in the study. Equal ones count each."""
        return self.points or len(self.rows(self.max_points))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return tuple(axis.name for axis in self.axes)

    @property
    def grows(self) -> bool:
        """Whether further points follow those of the study, so that more points keep these."""
        return self.kind not in ("latin_hypercube", "zip")

    def sequence(self, count: int, after: int = 0) -> list[Parameters]:
        """Return the next ``count`` points of the sequence, in order; equal ones stand each time.

        They come ``after`` some others, `size` of which the study has. At the end of a design that
        does not grow, they are fewer. Raises ``InputError`` if too few satisfy ``where``.
        """
        return [self.parameters_at(row) for row in self.rows(after + count)[after:]]

    def rows(self, count: int) -> list[dict[str, Any]]:
        """Return the values by parameter of the first ``count`` points, as `sequence` does."""
        return self._draw(count)[1]

    def shares(self, count: int) -> np.ndarray:
        """Return the first ``count`` points in the unit cube, shape (count, number of axes).

        Each number is the share of the distribution below the value: with the bounds [0, 1], the
        sample of SALib for ``saltelli`` (without second order) and ``morris`` (of four levels).
        """
        return self._draw(count)[0]

    def _draw(self, count: int) -> tuple[np.ndarray, list[dict[str, Any]]]:
        shares: list[np.ndarray] = []
        rows: list[dict[str, Any]] = []
        drawn = 0
        comparisons = [read_comparison(text) for text in self.where or []]
        for chunk, columns in self._chunks(count if self.grows else self.max_points):
            conditions = [one.satisfied(columns) for one in comparisons if one]
            chosen = np.flatnonzero(np.all(conditions, axis=0)) if conditions else range(len(chunk))
            shares.append(chunk[chosen])
            rows += [{name: values[i] for name, values in columns.items()} for i in chosen]
            drawn += len(chunk)
            if len(rows) >= count or (drawn >= _MIN_DRAWN and len(rows) < _MIN_SHARE * drawn):
                break
        if not rows or (self.grows and len(rows) < count):
            source, key = self.place
            allowed = "conditions that at least 1 in 1,000 points of the design satisfies"
            raise InputError.of_value(source, f"{key}.where", self.where, allowed)
        return np.concatenate(shares)[:count], rows[:count]

    def _chunks(self, count: int) -> Iterator[tuple[np.ndarray, Mapping[str, list[Any]]]]:
        if self.kind == "zip":
            yield np.empty((self.max_points, 0)), self._values
            return
        for shares in unit_points(self.kind, len(self.axes), count, self.seed):
            pairs = zip(self.axes, shares.T, strict=True)
            yield shares, {axis.name: axis.values(column) for axis, column in pairs}
