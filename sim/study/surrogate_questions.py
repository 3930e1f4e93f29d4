"""Questions to surrogates: what matters, and which parameters measurements allow."""

from collections.abc import Iterator
from typing import Any

from sim.base.additions import plain_name
from sim.base.errors import Allowed, InputError, count_text
from sim.base.messages import did_you_mean, one_of
from sim.parameters import SYSTEMS, field_info
from sim.parameters.common import CHOICES
from sim.parameters.density import DENSITY
from sim.study.design import Axis, block_size
from sim.study.measured import PURE, MeasuredTable, read_measured
from sim.study.plot_contents import name_in_words
from sim.study.plot_kinds import FigureSpec
from sim.study.plottable import find_observable, numbers
from sim.study.questions import Question
from sim.study.surrogate import (
    COUNTED,
    FEWEST_BLOCKS,
    MOST_MEASUREMENTS,
    CalibrateFile,
    CalibrationSpec,
    SensitivityFile,
    SensitivitySpec,
    SurrogateSpec,
)

#: Least error and largest number of a measurement.
_TINY, _HUGE = 1e-100, 1e100


class _Asked(Question):
    """A question to a surrogate, or to the runs of a series."""

    def surrogate(self) -> SurrogateSpec:
        """Return the surrogate that the entry names; its parameters must all be numbers."""
        named = {one.name: one for one in self.study.surrogates}
        name = self.entry.surrogate
        if name not in named:
            allowed = "one of " + ", ".join(named) if named else "the name of a surrogate"
            raise self.error("surrogate", name, Allowed(did_you_mean(name, named), allowed))
        for axis in named[name].axes:
            if not axis.is_number:
                got = f"{name}, which varies {axis.name}"
                raise self.error("surrogate", got, "a surrogate whose parameters are all numbers")
        return named[name]


class SensitivityQuestion(_Asked):
    """An entry under ``sensitivity``."""

    entry: SensitivityFile

    def spec(self) -> SensitivitySpec:
        """Return the question."""
        if self.entry.surrogate is not None:
            return SensitivitySpec(
                self.entry.name, self.surrogate(), surrogate_error=self.entry.surrogate_error
            )
        name = self.entry.series
        design = self.study.designs.get(name)
        if design is None or design.kind not in ("saltelli", "morris"):
            others = [key for key, one in self.study.designs.items() if block_size(one.kind, 2) > 1]
            hint = f": {', '.join(others)}" if others else ""
            allowed = f"a series whose design is of kind saltelli or morris{hint}"
            raise self.error("series", name, allowed)
        if DENSITY in design.names:
            raise self.error("series", name, f"a series whose design is over mass, not {DENSITY}")
        block = block_size(design.kind, len(design.axes))
        if design.size < FEWEST_BLOCKS * block:
            got = f"{name} of {design.size} points"
            raise self.error("series", got, f"a design of {FEWEST_BLOCKS * block} points or more")
        system = self.study.points[self.study.series[name][0]].parameters.system
        observable = self.entry.observable or "velocity"
        find_observable("curves", "observable", observable, system, self.error)
        regimes = tuple(dict.fromkeys(self.entry.regimes or COUNTED))
        of = SurrogateSpec(self.entry.name, name, observable, system, design.axes, regimes)
        return SensitivitySpec(self.entry.name, of, design)

    def pictures(self, spec: SensitivitySpec) -> Iterator[FigureSpec]:
        """Yield the pictures of the answer."""
        observable = numbers(spec.of.system)[spec.of.observable]
        what = name_in_words(observable.name)
        source = f"surrogate {spec.of.name}" if spec.design is None else f"series {spec.of.series}"
        if spec.is_screening:
            yield self.picture(
                spec,
                spec.of,
                "screening",
                f"Screening of what changes the {what}",
                f"Elementary effects of each parameter on {what} ({observable.meaning}), from the "
                f"runs of the {source}.",
            )
            return
        yield self.picture(
            spec,
            spec.of,
            "indices",
            f"What the {what} depends on",
            f"Sobol' indices of {what} ({observable.meaning}), from the {source}.",
        )
        if spec.design is None and len(spec.of.axes) > 1:
            yield self.picture(
                spec,
                spec.of,
                "interactions",
                f"What acts together on the {what}",
                f"Second-order Sobol' indices of {what} ({observable.meaning}), from the {source}.",
            )


class CalibrationQuestion(_Asked):
    """An entry under ``calibrate``."""

    entry: CalibrateFile

    def spec(self) -> CalibrationSpec:
        """Return the question, with its measurements."""
        surrogate = self.surrogate()
        axes = {axis.name: axis for axis in surrogate.axes}
        for name, (low, high) in self.entry.parameters.items():
            if name not in axes:
                raise self.error(f"parameters.{name}", [low, high], one_of(name, axes))
            if low < axes[name].low or high > axes[name].high:
                ends = f"[{axes[name].low:g}, {axes[name].high:g}]"
                allowed = f"a range within {ends}, that of surrogate {surrogate.name}"
                raise self.error(f"parameters.{name}", [low, high], allowed)
        table = read_measured(self.path.parent / self.entry.data)
        if (count := len(table.lines)) > MOST_MEASUREMENTS:
            allowed = f"{MOST_MEASUREMENTS:,} or fewer; average those made under equal conditions"
            raise InputError.of_value(table.path, "measurements", count, allowed)
        for name in self.entry.units:
            table.require_column(name, "as units has it")
        values, errors = self._measurements(table, surrogate)
        conditions = {
            name: self._condition(table, axis, surrogate)
            for name, axis in axes.items()
            if name not in self.entry.parameters
        }
        self._require_other_columns(table, surrogate)
        ranges = {name: (float(a), float(b)) for name, (a, b) in self.entry.parameters.items()}
        return CalibrationSpec(
            self.entry.name,
            surrogate,
            ranges,
            conditions,
            values,
            errors,
            table.path,
            self.entry.discrepancy,
            self.entry.surrogate_error,
        )

    def _measurements(
        self, table: MeasuredTable, surrogate: SurrogateSpec
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return what was measured and its errors, in the unit of the observable."""
        observable = numbers(surrogate.system)[surrogate.observable]
        name, units = self.entry.observable or observable.name, self.entry.units
        column = self.entry.error or f"{name}_error"
        table.require_column(name, "what was measured")
        table.require_column(column, f"the standard error of {name}; error: names another")
        for key, own, taken in (("observable", name, ()), ("error", column, (name,))):
            if own in (*taken, *SYSTEMS[surrogate.system].model_fields):
                allowed = "a column of its own: neither a parameter nor what was measured"
                raise self.error(key, own, allowed)
        unit = units.get(name, "")
        values = table.numbers(
            name, observable.unit, unit=unit, low=-_HUGE, high=_HUGE, allowed="a number"
        )
        # Errors are in the unit of what was measured, unless they have one of their own.
        of_errors = units.get(column, "" if table.units[column] else unit or table.units[name])
        errors = table.numbers(
            column, observable.unit, unit=of_errors, low=_TINY, high=_HUGE, allowed="an error > 0"
        )
        return values, errors

    def _condition(
        self, table: MeasuredTable, axis: Axis, surrogate: SurrogateSpec
    ) -> tuple[float, ...]:
        """Return the values of a parameter at each measurement."""
        table.require_column(
            axis.name, f"as surrogate {surrogate.name} varies it and parameters does not name it"
        )
        unit = field_info(SYSTEMS[surrogate.system])[axis.name].unit
        allowed = (
            f"a number in [{axis.low:g}, {axis.high:g}]"
            + (f" {unit}" if unit != PURE else "")
            + f", the range of surrogate {surrogate.name}"
        )
        own = self.entry.units.get(axis.name, "")
        return table.numbers(
            axis.name, unit, unit=own, low=axis.low, high=axis.high, allowed=allowed
        )

    def _require_other_columns(self, table: MeasuredTable, surrogate: SurrogateSpec) -> None:
        """Refuse columns of parameters that are looked for, or that no run has these values of."""
        fields = field_info(SYSTEMS[surrogate.system])
        axes = {axis.name for axis in surrogate.axes} - self.entry.parameters.keys()
        points = [self.study.points[key].parameters for key in self.study.series[surrogate.series]]
        for name in table.texts:
            if name not in fields or name in axes:
                continue
            if name in self.entry.parameters:
                allowed = f"parameters that {table.path.name} has no column of"
                raise self.error(f"parameters.{name}", self.entry.parameters[name], allowed)
            fixed, *others = dict.fromkeys(getattr(point, name) for point in points)
            if not others:
                unit = fields[name].unit
                self._require_value(
                    table, name, fixed, unit, f"as all points of {surrogate.series}"
                )

    def _require_value(
        self, table: MeasuredTable, name: str, fixed: Any, unit: str, reason: str
    ) -> None:
        """Refuse a column unless it has one value in all rows: a number, a word or a switch."""
        if type(fixed) in (int, float):
            own, slack = self.entry.units.get(name, ""), 1e-6 * abs(fixed)
            ends = {"low": fixed - slack, "high": fixed + slack}
            table.numbers(name, unit, unit=own, allowed=f"{fixed:g}, {reason}", **ends)
            return
        is_switch = isinstance(fixed, bool)
        word = str(fixed).lower() if is_switch else plain_name(fixed) if name in CHOICES else fixed
        for row, text in enumerate(table.texts[name]):
            if (text.lower() if is_switch else text) not in (word, fixed):
                raise table.error(row, name, text or None, f"{word or 'nothing'}, {reason}")

    def pictures(self, spec: CalibrationSpec) -> Iterator[FigureSpec]:
        """Yield the pictures of the answer."""
        observable = numbers(spec.of.system)[spec.of.observable]
        what = name_in_words(observable.name)
        source = f"surrogate {spec.of.name}"
        names = ", ".join(name_in_words(name) for name in spec.ranges)
        yield self.picture(
            spec,
            spec.of,
            "posterior",
            f"Which {names} the measurements allow",
            f"Posterior of {names} from {count_text(len(spec.values), 'measurement')} of {what} "
            f"({observable.meaning}), by the {source}.",
        )
        yield self.picture(
            spec,
            spec.of,
            "predictions",
            f"{what.capitalize()} measured and calibrated",
            f"{what.capitalize()} ({observable.meaning}): measurements, and what the calibrated "
            f"{source} says of each.",
        )
        if any(len(set(one)) > 1 for one in spec.conditions.values()):
            yield self.picture(
                spec,
                spec.of,
                "experiment",
                "The next experiment",
                f"Where a further measurement of {what} would narrow the posterior of {names}.",
            )
