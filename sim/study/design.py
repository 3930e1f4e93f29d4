"""Designs: points spread over ranges of parameters, in an order that more points go on with."""

import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, isfinite, log2, sqrt
from statistics import median
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from sim.base.errors import InputError
from sim.base.messages import allowed_values
from sim.parameters import AMOUNTS, Parameters, canonical_number
from sim.parameters.common import TWO_NUMBERS, Real, broken_rule
from sim.study.entries import Lists, Strict, optional

#: Digits of a value: so few that every machine rounds it to the same one.
SIGNIFICANT_DIGITS = 6

#: Kinds of design that keep their first points where more are wanted.
GROWING = ("sobol", "random", "saltelli", "morris")

#: Points of a sequence that are looked at before `where` may be given up, and the share of them
#: that must satisfy it.
_MIN_DRAWN, _MIN_SHARE = 2**16, 1e-3

#: Least number of points of a sequence that are made at once.
_MIN_CHUNK = 1024

_COMPARISONS: dict[str, Callable[[Any, Any], Any]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}
OPERATORS = tuple(_COMPARISONS)
_COMPARISON = re.compile(rf"\s*([\w.+-]+)\s*({'|'.join(OPERATORS)})\s*([\w.+-]+)\s*")


class Comparison(NamedTuple):
    """A condition on a point of a design; each side is a number or the name of a parameter."""

    left: float | str
    operator: str
    right: float | str

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters on its sides."""
        return tuple(side for side in (self.left, self.right) if isinstance(side, str))

    def __str__(self) -> str:
        """Return the text that says it."""
        return " ".join(one if isinstance(one, str) else f"{one:.12g}" for one in self)

    def satisfied(self, columns: Mapping[str, Sequence[Any]]) -> np.ndarray:
        """Return which points satisfy it, from the values of each parameter."""
        left, right = (
            np.asarray(columns[side]) if isinstance(side, str) else side
            for side in (self.left, self.right)
        )
        return np.asarray(_COMPARISONS[self.operator](left, right))


def _comparison(text: str) -> Comparison | None:
    """Return what a text such as ``friction < 0.5`` says, None where it is no comparison."""
    if not (match := _COMPARISON.fullmatch(text)):
        return None
    left, sign, right = match.groups()
    return Comparison(_number_or_name(left), sign, _number_or_name(right))


def _number_or_name(text: str) -> float | str:
    with suppress(ValueError):
        if isfinite(number := float(text)):
            return number
    return text


@dataclass(frozen=True)
class Axis:
    """A parameter that the points of a series vary, and how its values are spread.

    Attributes
    ----------
    name : str
        The parameter.
    low, high : float
        Lowest and highest value, in the unit of a study file; of words and switches the first and
        the last index of `choices`.
    scale : str
        ``linear`` or ``log``: in which scale values are evenly spread.
    choices : tuple
        The values that it takes; empty where it takes any between ``low`` and ``high``.
    normal : tuple of two floats, optional
        Mean and deviation of a normal distribution that is cut off at ``low`` and ``high``.
    is_integer : bool
        Whether it takes whole numbers alone.
    """

    name: str
    low: float
    high: float
    scale: Literal["linear", "log"] = "linear"
    choices: tuple[Any, ...] = ()
    normal: tuple[float, float] | None = None
    is_integer: bool = False

    @property
    def is_number(self) -> bool:
        """Whether its values are numbers; if not, they are words or switches."""
        return not any(isinstance(value, (str, bool)) for value in self.choices)

    def values(self, shares: np.ndarray) -> list[Any]:
        """Return the values below which shares of the distribution lie, shape (n,), from 0 to 1.

        Numbers are rounded to `SIGNIFICANT_DIGITS`, those of integer parameters to integers.
        """
        if self.choices:
            last = len(self.choices) - 1
            return [self.choices[min(int(share * (last + 1)), last)] for share in shares]
        # Half a unit more on both sides: the ends of a range of integers are as likely as others.
        margin = 0.5 if self.is_integer else 0.0
        low, high = self.low - margin, self.high + margin
        if self.normal:
            from scipy.stats import truncnorm

            mean, deviation = self.normal
            ends = (low - mean) / deviation, (high - mean) / deviation
            values = truncnorm.ppf(shares, *ends, loc=mean, scale=deviation)
        elif self.scale == "log":
            values = low * (high / low) ** shares
        else:
            values = low + (high - low) * shares
        if self.is_integer:
            return [int(value) for value in np.clip(np.rint(values), self.low, self.high)]
        rounded = (float(f"{value:.{SIGNIFICANT_DIGITS}g}") for value in values)
        return [min(max(value, self.low), self.high) for value in rounded]


def axis_of(name: str, values: Iterable[Any], is_integer: bool) -> Axis:
    """Return the axis of a parameter with given values, as a grid has them.

    It has no choices but words and switches. Its scale is ``log`` where the median of the values is
    nearer to the geometric mean of the lowest and the highest than to their mean.
    """
    different = tuple(dict.fromkeys(values))
    if any(isinstance(value, (str, bool)) for value in different):
        return Axis(name, 0.0, len(different) - 1.0, choices=different)
    low, high, middle = map(float, (min(different), max(different), median(different)))
    is_log = low > 0 and abs(middle - sqrt(low * high)) < abs(middle - (low + high) / 2)
    return Axis(name, low, high, "log" if is_log else "linear", is_integer=is_integer)


def unit_points(kind: str, dimensions: int, count: int, seed: int) -> Iterator[np.ndarray]:
    """Yield points of the unit cube in order, at least ``count``; more of kinds with `where`."""
    if kind in ("sobol", "random"):
        # Sobol's first points are balanced if their number is a power of two.
        size = 2 ** ceil(log2(max(count, _MIN_CHUNK)))
        if kind == "random":
            draw = np.random.default_rng(seed).random
            while True:
                yield draw((size, dimensions))
        from scipy.stats import qmc

        sobol = qmc.Sobol(dimensions, rng=seed)
        while True:
            yield sobol.random(size)
    elif kind == "latin_hypercube":
        from scipy.stats import qmc

        yield qmc.LatinHypercube(dimensions, rng=seed).random(count)
    else:
        from SALib.sample import morris
        from SALib.sample import sobol as saltelli

        names = [str(number) for number in range(dimensions)]
        problem = {"num_vars": dimensions, "names": names, "bounds": [[0, 1]] * dimensions}
        blocks = ceil(count / block_size(kind, dimensions))
        if kind == "saltelli":
            number = 2 ** ceil(log2(blocks))
            yield saltelli.sample(problem, number, calc_second_order=False, seed=seed)
        else:
            yield morris.sample(problem, blocks, seed=seed)


def block_size(kind: str, dimensions: int) -> int:
    """Return the number of points that belong together: an analysis needs whole blocks."""
    return {"saltelli": dimensions + 2, "morris": dimensions + 1}.get(kind, 1)


_ALLOWED_VALUES = f"{TWO_NUMBERS}; {{between, scale}}, {{mean, deviation, between}} or {{choices}}"
_ALLOWED_COMPARISON = (
    f"two sides with one of {' '.join(OPERATORS)} between, numbers or parameters under over that "
    "take numbers"
)


#: Largest deviation of a normal distribution, in ranges: what is wider cannot be told from even.
MOST_RANGES = 1000.0


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
        "the values, each equally often",
        {"allowed": "a list of two different values or more"},
        min_length=2,
    )

    def rules(self) -> Iterator[PydanticCustomError]:
        given = self.model_dump(exclude_unset=True)
        if given.keys() not in (
            {"between"},
            {"between", "scale"},
            {"between", "mean", "deviation"},
            {"choices"},
        ):
            yield broken_rule("", given, _ALLOWED_VALUES)
        if self.between:
            low, high = self.between
            if not low < high:
                yield broken_rule("between", self.between, TWO_NUMBERS)
            if self.scale == "log" and low <= 0:
                yield broken_rule("between", self.between, "two numbers > 0 where the scale is log")
            if self.mean is not None and not low <= self.mean <= high:
                allowed = f"a number in [{low:g}, {high:g}], as of between"
                yield broken_rule("mean", self.mean, allowed)
            if self.deviation is not None and self.deviation > MOST_RANGES * (high - low):
                allowed = f"a number <= {MOST_RANGES:g} times the range; what is wider is even"
                yield broken_rule("deviation", self.deviation, allowed)
        choices = self.choices or []
        if not all(isinstance(value, bool | int | float | str) for value in choices) or len(
            {str(canonical_number(value)) for value in choices}
        ) < len(choices):
            yield broken_rule("choices", choices, "a list of two different values or more")

    def axis(self, name: str, is_integer: bool) -> Axis:
        """Return the axis of a parameter that is spread like this."""
        if self.choices:
            axis = axis_of(name, self.choices, is_integer)
            return replace(axis, choices=tuple(self.choices))
        normal = None if self.mean is None else (self.mean, self.deviation)
        low, high = self.between
        return Axis(name, low, high, self.scale, normal=normal, is_integer=is_integer)


def read_values(value: Any) -> Any:
    """Return what a mapping says of the values of a parameter; a list stays one."""
    if isinstance(value, dict):
        return Distribution.model_validate(value)
    if not isinstance(value, list) or not value:
        raise broken_rule("", value, _ALLOWED_VALUES)
    return value


class Over(Lists):
    """Values of the parameters of a design."""

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return a hint at the intended key, empty if there is none."""
        if key in AMOUNTS:
            return f"{key} belongs under base, as it makes no other point"
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

    def rules(self) -> Iterator[PydanticCustomError]:
        yield from self._wrong_values()
        yield from self._wrong_number()
        if self.where and self.kind not in ("sobol", "random", "zip"):
            allowed = f"none with {self.kind}, whose points belong together"
            yield broken_rule("where", self.where, allowed)
        numeric = {axis.name for axis in self.axes if axis.is_number}
        for index, text in enumerate(self.where or []):
            comparison = _comparison(text)
            if not comparison or not comparison.names or not numeric.issuperset(comparison.names):
                yield broken_rule(f"where[{index}]", text, _ALLOWED_COMPARISON)

    def _wrong_values(self) -> Iterator[PydanticCustomError]:
        values = self._values
        first = next(iter(values))
        for name, given in values.items():
            if self.kind != "zip":
                spread = self._distribution(name)
                yield from self._not_allowed(name, spread.choices or spread.between)
            elif not isinstance(given, list):
                yield broken_rule(
                    f"over.{name}",
                    given.model_dump(exclude_unset=True),
                    "a list of values, as kind is zip",
                )
            elif len(given) != (wanted := len(values[first])):
                yield broken_rule(f"over.{name}", given, f"{wanted} values, as {first} has")
            else:
                yield from self._not_allowed(name, given)

    def _not_allowed(self, name: str, values: Iterable[Any]) -> Iterator[PydanticCustomError]:
        field = self._field(name)
        kind: Any = Annotated[(field.annotation, *field.metadata, None)]
        adapter = TypeAdapter(kind, config=ConfigDict(strict=True, allow_inf_nan=False))
        for value in values:
            if self._is_integer(name) and isinstance(value, float) and value.is_integer():
                value = int(value)
            try:
                adapter.validate_python(value)
            except ValidationError:
                yield broken_rule(f"over.{name}", value, allowed_values(field))

    def _wrong_number(self) -> Iterator[PydanticCustomError]:
        if self.kind == "zip":
            if self.points is not None:
                yield broken_rule("points", self.points, "none, as the lists of zip say how many")
            return
        if self.points is None:
            yield broken_rule("points", None, "an integer >= 1")
            return
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
        if self.points not in fitting:
            allowed = f"{fitting[0]:,} or {fitting[1]:,}, as {block} times {factor}"
            yield broken_rule("points", self.points, allowed)

    @property
    def _values(self) -> dict[str, Any]:
        return {name: values for name, values in self.over if values is not None}

    def _distribution(self, name: str) -> Distribution:
        values = self._values[name]
        if not isinstance(values, list):
            return values
        try:
            return Distribution(between=values)
        except ValidationError:
            raise broken_rule(f"over.{name}", values, _ALLOWED_VALUES) from None

    def _field(self, name: str) -> FieldInfo:
        return (self.over.parameters.model_fields | self.over.in_place)[name]

    def _is_integer(self, name: str) -> bool:
        return self._field(name).annotation is int

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The parameters that it varies, in the order of the reference."""
        return tuple(
            axis_of(name, values, self._is_integer(name))
            if self.kind == "zip"
            else self._distribution(name).axis(name, self._is_integer(name))
            for name, values in self._values.items()
        )

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
        return self.kind in GROWING

    def sequence(self, count: int, after: int = 0) -> list[Parameters]:
        """Return the next points of the sequence, in order; equal ones stand there each time.

        Parameters
        ----------
        count : int
            Number of points. Fewer come back at the end of a design that does not grow.
        after : int
            Number of points before them; `size` for the first ones that the study does not have.

        Raises
        ------
        InputError
            If too few points satisfy ``where``, or a point is not valid.
        """
        return [self.parameters_at(row) for row in self.rows(after + count)[after:]]

    def rows(self, count: int) -> list[dict[str, Any]]:
        """Return the values by parameter of the first ``count`` points, as `sequence` does."""
        return self._draw(count)[1]

    def shares(self, count: int) -> np.ndarray:
        """Return the first ``count`` points in the unit cube, shape (count, number of axes).

        Each number is the share of the distribution below the value. With the bounds [0, 1], this
        is the sample that SALib has made for ``saltelli`` (without second order) and ``morris``
        (of four levels). It has no columns for ``zip``.
        """
        return self._draw(count)[0]

    def _draw(self, count: int) -> tuple[np.ndarray, list[dict[str, Any]]]:
        shares: list[np.ndarray] = []
        rows: list[dict[str, Any]] = []
        drawn = 0
        comparisons = [_comparison(text) for text in self.where or []]
        for chunk, columns in self._chunks(count if self.grows else self.max_points):
            conditions = [one.satisfied(columns) for one in comparisons if one]
            chosen = np.flatnonzero(np.all(conditions, axis=0)) if conditions else range(len(chunk))
            shares.append(chunk[chosen])
            rows += [{name: values[i] for name, values in columns.items()} for i in chosen]
            drawn += len(chunk)
            if len(rows) >= count or (drawn >= _MIN_DRAWN and len(rows) < _MIN_SHARE * drawn):
                break
        if not rows or (self.grows and len(rows) < count):
            given = [str(one) for one in comparisons]
            allowed = "conditions that at least 1 in 1,000 points of the design satisfies"
            source, key = self.place
            raise InputError.of_value(source, f"{key}.where", given, allowed)
        return np.concatenate(shares)[:count], rows[:count]

    def _chunks(self, count: int) -> Iterator[tuple[np.ndarray, Mapping[str, list[Any]]]]:
        if self.kind == "zip":
            yield np.empty((self.max_points, 0)), self._values
            return
        for shares in unit_points(self.kind, len(self.axes), count, self.seed):
            yield (
                shares,
                {
                    axis.name: axis.values(column)
                    for axis, column in zip(self.axes, shares.T, strict=True)
                },
            )
