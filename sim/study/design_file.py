"""The key ``design`` of a series: a design as a study file gives it."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from math import log2
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError, model_validator
from pydantic.fields import FieldInfo

from sim.base.messages import allowed_values
from sim.parameters import AMOUNTS, Parameters, canonical_number
from sim.parameters.common import TWO_NUMBERS, Real, broken_rule
from sim.study.design import (
    OPERATORS,
    Axis,
    Design,
    axis_of,
    block_size,
    parse_comparison,
)
from sim.study.entries import Lists, Strict, optional

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
        "lowest and highest value",
        {"allowed": TWO_NUMBERS},
        min_length=2,
        max_length=2,
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

    @model_validator(mode="after")
    def _require_one_kind(self) -> Self:
        given = self.model_dump(exclude_unset=True)
        if given.keys() not in (
            {"between"},
            {"between", "scale"},
            {"between", "mean", "deviation"},
            {"choices"},
        ):
            raise broken_rule("", given, _ALLOWED_VALUES)
        return self

    @model_validator(mode="after")
    def _require_valid_range(self) -> Self:
        if not self.between:
            return self
        low, high = self.between
        if not low < high:
            raise broken_rule("between", self.between, TWO_NUMBERS)
        if self.scale == "log" and low <= 0:
            raise broken_rule("between", self.between, "two numbers > 0 where the scale is log")
        if self.mean is not None and not low <= self.mean <= high:
            raise broken_rule("mean", self.mean, f"a number in [{low:g}, {high:g}], as of between")
        if self.deviation is not None and self.deviation > MOST_RANGES * (high - low):
            allowed = f"a number <= {MOST_RANGES:g} times the range; what is wider is even"
            raise broken_rule("deviation", self.deviation, allowed)
        return self

    @model_validator(mode="after")
    def _require_different_choices(self) -> Self:
        choices = self.choices or []
        if not all(isinstance(value, bool | int | float | str) for value in choices) or len(
            {str(canonical_number(value)) for value in choices}
        ) < len(choices):
            raise broken_rule("choices", choices, "a list of two different values or more")
        return self


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

    @model_validator(mode="after")
    def _require_values(self) -> Self:
        values = self._values
        first = next(iter(values))
        for name, given in values.items():
            if self.kind != "zip":
                spread = self._distribution(name)
                self._require_allowed(name, spread.choices or spread.between)
            elif not isinstance(given, list):
                raise broken_rule(
                    f"over.{name}",
                    given.model_dump(exclude_unset=True),
                    "a list of values, as kind is zip",
                )
            elif len(given) != (wanted := len(values[first])):
                raise broken_rule(f"over.{name}", given, f"{wanted} values, as {first} has")
            else:
                self._require_allowed(name, given)
        return self

    def _require_allowed(self, name: str, values: Iterable[Any]) -> None:
        """Raise where one of some values is none that the parameter may have."""
        field = self._field(name)
        kind: Any = Annotated[(field.annotation, *field.metadata, None)]
        adapter = TypeAdapter(kind, config=ConfigDict(strict=True, allow_inf_nan=False))
        for value in values:
            if self._is_integer(name) and isinstance(value, float) and value.is_integer():
                value = int(value)
            try:
                adapter.validate_python(value)
            except ValidationError:
                raise broken_rule(f"over.{name}", value, allowed_values(field)) from None

    @model_validator(mode="after")
    def _require_number(self) -> Self:
        if self.kind == "zip":
            if self.points is not None:
                raise broken_rule("points", self.points, "none, as the lists of zip say how many")
            return self
        if self.points is None:
            raise broken_rule("points", None, "an integer >= 1")
        block = block_size(self.kind, len(self._values))
        blocks = max(2, self.points // block)
        match self.kind:
            case "saltelli":
                blocks = 2 ** int(log2(blocks))
                fitting, factor = (blocks * block, 2 * blocks * block), "a power of two"
            case "morris":
                fitting, factor = (blocks * block, (blocks + 1) * block), "two or more"
            case _:
                return self
        if self.points not in fitting:
            allowed = f"{fitting[0]:,} or {fitting[1]:,}, as {block} times {factor}"
            raise broken_rule("points", self.points, allowed)
        return self

    @model_validator(mode="after")
    def _require_comparisons(self) -> Self:
        if self.where and self.kind not in ("sobol", "random", "zip"):
            allowed = f"none with {self.kind}, whose points belong together"
            raise broken_rule("where", self.where, allowed)
        numeric = {axis.name for axis in self.axes if axis.is_number}
        for index, text in enumerate(self.where or []):
            comparison = parse_comparison(text)
            if not comparison or not comparison.names or not numeric.issuperset(comparison.names):
                raise broken_rule(f"where[{index}]", text, _ALLOWED_COMPARISON)
        return self

    @property
    def _values(self) -> dict[str, Any]:
        """List or distribution of each parameter, in the order of the reference."""
        return {name: values for name, values in self.over if values is not None}

    def _distribution(self, name: str) -> Distribution:
        """Return how the values of a parameter are spread; a list has the ends of a range."""
        values = self._values[name]
        if not isinstance(values, list):
            return values
        try:
            return Distribution(between=values)
        except ValidationError:
            raise broken_rule(f"over.{name}", values, _ALLOWED_VALUES) from None

    def _axis(self, name: str) -> Axis:
        spread = self._distribution(name)
        if spread.choices:
            axis = axis_of(name, spread.choices, self._is_integer(name))
            return replace(axis, choices=tuple(spread.choices))
        low, high = spread.between
        return Axis(
            name,
            low,
            high,
            spread.scale,
            normal=None if spread.mean is None else (spread.mean, spread.deviation),
            is_integer=self._is_integer(name),
        )

    def _field(self, name: str) -> FieldInfo:
        return (self.over.parameters.model_fields | self.over.in_place)[name]

    def _is_integer(self, name: str) -> bool:
        return self._field(name).annotation is int

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The parameters that it varies."""
        if self.kind == "zip":
            return tuple(
                axis_of(name, values, self._is_integer(name))
                for name, values in self._values.items()
            )
        return tuple(self._axis(name) for name in self._values)

    @property
    def max_points(self) -> int:
        """Number of points, those of zip that do not satisfy ``where`` included."""
        return self.points or len(next(iter(self._values.values())))

    def design(
        self, parameters_at: Callable[[Mapping[str, Any]], Parameters], place: tuple[str, str]
    ) -> Design:
        """Return the design; see its attributes for the arguments."""
        comparisons = (parse_comparison(text) for text in self.where or [])
        design = Design(
            kind=self.kind,
            axes=self.axes,
            size=self.max_points,
            seed=self.seed,
            where=tuple(filter(None, comparisons)),
            parameters_at=parameters_at,
            place=place,
            columns=self._values if self.kind == "zip" else {},
        )
        # Conditions leave out pairs of lists.
        return replace(design, size=len(design.rows(design.size))) if design.columns else design
