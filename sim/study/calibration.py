"""Entries under ``calibrate`` of a study file: which parameters measurements allow."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import Field

from sim.base.additions import plain_name
from sim.base.errors import InputError
from sim.base.measured import ALLOWED_FILE, FILE, PURE, MeasuredTable, read_measured
from sim.base.messages import one_of
from sim.parameters import SYSTEMS, field_info
from sim.parameters.common import CHOICES, TWO_NUMBERS, Real, broken_rule
from sim.study.design import Axis
from sim.study.entries import optional
from sim.study.plottable import numbers
from sim.study.surrogate import (
    ACCEPTED_ERROR,
    Place,
    Question,
    SurrogateFile,
    name_field,
    surrogate_named,
)

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
