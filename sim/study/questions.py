"""Questions of a study to its surrogates: what matters, what follows, which parameters.

They stand under ``sensitivity`` and ``propagate``, which may also be asked of the runs of a design
made for them, and under ``calibrate``.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, ValidationError
from pydantic_core import PydanticCustomError

from sim.base.additions import plain_name
from sim.base.errors import InputError
from sim.base.measured import ALLOWED_FILE, FILE, PURE, MeasuredTable, read_measured
from sim.base.messages import one_of
from sim.parameters import SYSTEMS, FieldRow, field_info
from sim.parameters.common import CHOICES, TWO_NUMBERS, Real, broken_rule
from sim.study.design import Axis, block_size
from sim.study.design_file import ALLOWED_VALUES, distribution, read_values
from sim.study.entries import optional
from sim.study.plottable import find_observable, numbers
from sim.study.surrogate import (
    ACCEPTED_ERROR,
    COUNTED,
    Place,
    Question,
    Regime,
    SurrogateFile,
    name_field,
    surrogate_named,
)

#: Fewest blocks, trajectories of Morris or runs of other designs that give an answer.
FEWEST_BLOCKS = 8


class _OfSurrogateOrRuns(Question):
    """A question that a surrogate answers, or the runs of a design made for it."""

    ending: ClassVar[str] = ".csv"

    #: Kinds of design whose runs can answer it, and what `resolve` adds: the surrogate, or what one
    #: of the series would be; and the design of the series whose runs are analysed.
    kinds: ClassVar[tuple[str, ...]]
    of: ClassVar[SurrogateFile]
    design: ClassVar[Any] = None

    name: str
    surrogate: str = optional("surrogate whose observable is explained")
    series: str = optional("in place of a surrogate: series with a design")
    observable: str = optional("of a series: observable, any number of `plots` (velocity)")
    regimes: list[Regime] = optional(
        "of a series: regimes whose points count (steady, mixed, undetermined); others, and blocks "
        "with them, are left out",
        min_length=1,
    )
    surrogate_error: Real = optional(f"of a surrogate: {ACCEPTED_ERROR}", gt=0, le=10)

    def require_rules(self) -> None:
        if self.surrogate is not None:
            for key in ("series", "observable", "regimes"):
                is_left = getattr(self, key) is None
                self.require(key, is_left, "none with surrogate, which has its own")
            return
        self.require("surrogate", self.series, "the name of a surrogate, or series: a series")
        allowed = "none with series, whose runs need no surrogate"
        self.require("surrogate_error", self.surrogate_error is None, allowed)

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the question with its surrogate, or with the design of its series."""
        if self.surrogate is not None:
            return self.with_values(of=surrogate_named(self.surrogate, study, place))
        name = self.series
        design = study.designs.get(name)
        if design is None or design.kind not in self.kinds:
            others = [key for key, one in study.designs.items() if one.kind in self.kinds]
            hint = f": {', '.join(others)}" if others else ""
            allowed = f"a series whose design is of kind {' or '.join(self.kinds)}{hint}"
            raise place.error("series", name, allowed)
        if "density" in design.names:
            raise place.error("series", name, "a series whose design is over mass, not density")
        fewest = FEWEST_BLOCKS * block_size(design.kind, len(design.axes))
        if design.size < fewest:
            allowed = f"a design of {fewest} points or more"
            raise place.error("series", f"{name} of {design.size} points", allowed)
        system = study.points[study.series[name][0]].parameters.system
        observable = self.observable or "velocity"
        find_observable("curves", "observable", observable, system, place.error)
        regimes = self.regimes or list(COUNTED)
        of = SurrogateFile(name=self.name, series=name, observable=observable, regimes=regimes)
        of = of.with_values(system=system, axes=design.axes)
        return self.with_values(of=of, design=design)

    @property
    def settings(self) -> tuple[Any, ...]:
        own = (self.design.kind, self.design.size, self.design.seed) if self.design else ()
        return (self.name, *own, self.surrogate_error, self.of.settings)


class SensitivityFile(_OfSurrogateOrRuns):
    """What matters: indices of a surrogate, or of the runs of a design made for them."""

    folder: ClassVar[str] = "sensitivity"
    kinds: ClassVar[tuple[str, ...]] = ("saltelli", "morris")

    name: str = name_field("answer", "among sensitivities")
    series: str = optional(
        "in place of a surrogate: series whose design is of kind `saltelli` or `morris`"
    )

    @property
    def is_screening(self) -> bool:
        """Whether it is Morris' screening."""
        return self.design is not None and self.design.kind == "morris"


class PropagationFile(_OfSurrogateOrRuns):
    """How an observable is spread where parameters are: by a surrogate, or by runs."""

    folder: ClassVar[str] = "propagation"
    kinds: ClassVar[tuple[str, ...]] = ("sobol", "latin_hypercube", "random")

    #: What `resolve` adds of a surrogate: how its parameters are spread, and conditions on them.
    axes: ClassVar[tuple[Axis, ...]] = ()
    where: ClassVar[tuple[str, ...]] = ()

    name: str = name_field("answer", "among propagations")
    series: str = optional(
        "in place of a surrogate: series whose design is of kind `sobol`, `latin_hypercube` or "
        "`random`"
    )
    over: dict[str, Any] = optional(
        "of a surrogate: how parameters are spread, as in a design (omitted: as in its own)"
    )
    quantiles: list[Annotated[Real, Field(gt=0, lt=1)]] = Field(
        [0.05, 0.25, 0.5, 0.75, 0.95], description="quantiles asked for", min_length=1
    )
    exceeds: list[Real] = Field(
        [], description="values, in SI units, of which the probability to exceed them is asked for"
    )

    def require_rules(self) -> None:
        super().require_rules()
        is_possible = self.surrogate is not None or self.over is None
        self.require("over", is_possible, "none with series, whose design has them")

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the question with the distributions of its parameters."""
        asked = super().resolve(study, place)
        if asked.design is not None:
            return asked
        design = study.designs.get(asked.of.series)
        known = {axis.name: axis for axis in asked.of.axes}
        for name, value in (self.over or {}).items():
            if name not in known:
                raise place.error(f"over.{name}", value, one_of(name, known))
            row = field_info(SYSTEMS[asked.of.system])[name]
            known[name] = _spread(known[name], value, row, place)
        where = tuple((design and design.where) or ())
        return asked.with_values(axes=tuple(known.values()), where=where)

    @property
    def settings(self) -> tuple[Any, ...]:
        spread = tuple((axis.name, axis.low, axis.high, axis.normal) for axis in self.axes)
        return (*super().settings, spread, tuple(self.quantiles), tuple(self.exceeds))


def _spread(axis: Axis, value: Any, row: FieldRow, place: Place) -> Axis:
    """Return how a parameter of a surrogate is spread by a value under ``over``."""
    try:
        spread = distribution(read_values(value, row)).axis(axis.name, axis.is_integer)
    except (ValidationError, PydanticCustomError):
        raise place.error(f"over.{axis.name}", value, ALLOWED_VALUES) from None
    if not axis.low <= spread.low < spread.high <= axis.high or not spread.is_number:
        allowed = f"values within [{axis.low:g}, {axis.high:g}], that of its surrogate"
        raise place.error(f"over.{axis.name}", value, allowed)
    return spread


#: Most measurements: each is predicted some 100,000 times.
MOST_MEASUREMENTS = 1000

#: Least error and largest number of a measurement, and type of numbers of all measurements.
_TINY, _HUGE = 1e-100, 1e100
_Numbers = tuple[float, ...]


class CalibrateFile(Question):
    """Which parameters measurements allow, by a surrogate."""

    folder: ClassVar[str] = "calibration"

    #: What `resolve` adds: the surrogate; values of its other parameters at each measurement; the
    #: measurements and their standard errors, in the unit of the observable; and their file.
    of: ClassVar[SurrogateFile]
    conditions: ClassVar[Mapping[str, _Numbers]]
    values: ClassVar[_Numbers]
    errors: ClassVar[_Numbers]
    path: ClassVar[Path]

    name: str = name_field("answer", "among calibrations")
    data: str = Field(
        pattern=FILE,
        description="CSV file in the folder of the study file: a row for each measurement; columns "
        "for the observable, its error and the conditions",
        json_schema_extra={"allowed": ALLOWED_FILE},
    )
    surrogate: str = Field(description="surrogate that stands for the model")
    parameters: dict[str, Any] = Field(
        description="parameters looked for, each with its lowest and highest value; they are "
        "evenly spread there before anything is measured",
        min_length=1,
        json_schema_extra={"allowed": f"a mapping of parameters to {TWO_NUMBERS}"},
    )
    observable: str = optional("column of the observable (omitted: its name)")
    error: str = optional(
        "column of the standard error of each measurement (omitted: `<observable>_error`)"
    )
    units: dict[str, str] = Field(
        {}, description="units of columns whose headings have none, as `velocity: mm/s`"
    )
    discrepancy: bool = Field(
        True,
        description="whether the model itself may lack something; `false` gives narrower intervals",
    )
    surrogate_error: Real = optional(ACCEPTED_ERROR, gt=0, le=10)

    def require_rules(self) -> None:
        for name, ends in self.parameters.items():
            is_pair = isinstance(ends, list) and [type(end) in (int, float) for end in ends]
            if is_pair != [True, True] or not ends[0] < ends[1]:
                raise broken_rule(f"parameters.{name}", ends, TWO_NUMBERS)

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the question with its surrogate and its measurements."""
        of = surrogate_named(self.surrogate, study, place)
        axes = {axis.name: axis for axis in of.axes}
        for name, (low, high) in self.parameters.items():
            if name not in axes:
                raise place.error(f"parameters.{name}", [low, high], one_of(name, axes))
            if low < axes[name].low or high > axes[name].high:
                ends = f"[{axes[name].low:g}, {axes[name].high:g}]"
                allowed = f"a range within {ends}, that of surrogate {of.name}"
                raise place.error(f"parameters.{name}", [low, high], allowed)
        table = read_measured(place.path.parent / self.data)
        if (count := len(table.lines)) > MOST_MEASUREMENTS:
            allowed = f"{MOST_MEASUREMENTS:,} or fewer; average those made under equal conditions"
            raise InputError.of_value(table.path, "measurements", count, allowed)
        for name in self.units:
            table.require_column(name, "as units has it")
        asked = self.with_values(of=of, path=table.path)
        values, errors = asked._measurements(table, place)
        others = [axis for axis in of.axes if axis.name not in self.parameters]
        conditions = {axis.name: asked._condition(table, axis) for axis in others}
        asked._require_other_columns(table, study, place)
        return asked.with_values(conditions=conditions, values=values, errors=errors)

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest value of each parameter looked for."""
        return {name: (float(low), float(high)) for name, (low, high) in self.parameters.items()}

    @property
    def settings(self) -> tuple[Any, ...]:
        parts = tuple(self.ranges.items()), tuple(self.conditions.items())
        own = (self.name, *parts, self.values, self.errors, self.discrepancy)
        return (*own, self.surrogate_error, self.of.settings)

    def _measurements(self, table: MeasuredTable, place: Place) -> tuple[_Numbers, _Numbers]:
        observable = numbers(self.of.system)[self.of.observable]
        name, units = self.observable or observable.name, self.units
        column = self.error or f"{name}_error"
        table.require_column(name, "what was measured")
        table.require_column(column, f"the standard error of {name}; error: names another")
        for key, own, taken in (("observable", name, ()), ("error", column, (name,))):
            if own in (*taken, *SYSTEMS[self.of.system].model_fields):
                allowed = "a column of its own: neither a parameter nor what was measured"
                raise place.error(key, own, allowed)
        to, unit = observable.unit, units.get(name, "")
        values = table.numbers(name, to, unit=unit, low=-_HUGE, high=_HUGE, allowed="a number")
        # Errors are in the unit of what was measured, unless they have one of their own.
        unit = units.get(column, "" if table.units[column] else unit or table.units[name])
        ends: dict[str, Any] = {"low": _TINY, "high": _HUGE, "allowed": "an error > 0"}
        return values, table.numbers(column, to, unit=unit, **ends)

    def _condition(self, table: MeasuredTable, axis: Axis) -> _Numbers:
        (name, low, high), of = (axis.name, axis.low, axis.high), f"surrogate {self.of.name}"
        table.require_column(name, f"as {of} varies it and parameters does not name it")
        unit, own = field_info(SYSTEMS[self.of.system])[name].unit, self.units.get(name, "")
        allowed = f"a number in [{low:g}, {high:g}]{f' {unit}' if unit != PURE else ''}"
        allowed += f", the range of {of}"
        return table.numbers(name, unit, unit=own, low=low, high=high, allowed=allowed)

    def _require_other_columns(self, table: MeasuredTable, study: Any, place: Place) -> None:
        """Refuse columns of parameters that are looked for, or that no run has these values of."""
        fields, of = field_info(SYSTEMS[self.of.system]), self.of
        axes = {axis.name for axis in of.axes} - self.parameters.keys()
        points = [study.points[key].parameters for key in study.series[of.series]]
        for name in table.texts:
            if name not in fields or name in axes:
                continue
            if name in self.parameters:
                allowed = f"parameters that {table.path.name} has no column of"
                raise place.error(f"parameters.{name}", self.parameters[name], allowed)
            fixed, *others = dict.fromkeys(getattr(point, name) for point in points)
            if not others:
                self._require_value(table, name, fixed)

    def _require_value(self, table: MeasuredTable, name: str, fixed: Any) -> None:
        """Refuse a column unless it has one value in all rows: a number, a word or a switch."""
        reason = f"as all points of {self.of.series}"
        if type(fixed) in (int, float):
            own, slack = self.units.get(name, ""), 1e-6 * abs(fixed)
            ends = {"low": fixed - slack, "high": fixed + slack}
            unit = field_info(SYSTEMS[self.of.system])[name].unit
            table.numbers(name, unit, unit=own, allowed=f"{fixed:g}, {reason}", **ends)
            return
        is_switch = isinstance(fixed, bool)
        word = str(fixed).lower() if is_switch else plain_name(fixed) if name in CHOICES else fixed
        for row, text in enumerate(table.texts[name]):
            if (text.lower() if is_switch else text) not in (word, fixed):
                raise table.error(row, name, text or None, f"{word or 'nothing'}, {reason}")
