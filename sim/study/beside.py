"""Data beside a plot, as its entry has them: points of the study file, or columns of CSV files."""

from collections.abc import Callable
from pathlib import Path

from sim.base.errors import InputError
from sim.study.measured import PURE, MeasuredTable, read_measured
from sim.study.plot_file import MAX_MAGNITUDE, BesideFile, PlotFile, allowed_on_logarithmic

#: Label; points (x, y), or (x, y, error of y), in the units of the plot; whether a line joins them.
DataSet = tuple[str, tuple[tuple[float, ...], ...], bool]


def data_sets(plot: PlotFile, folder: Path, unit_on: Callable[[str], str]) -> tuple[DataSet, ...]:
    """Return the data beside a plot.

    Parameters
    ----------
    plot : PlotFile
        The plot.
    folder : Path
        Folder of its files.
    unit_on : callable
        Function: axis, ``"x"`` or ``"y"`` → its unit as UDUNITS reads it; empty for a natural one.

    Raises
    ------
    InputError
        For a file that cannot be read, and for columns and numbers that cannot be drawn.
    """
    return tuple(
        (data.name, _points(plot, data, folder, unit_on), data.line) for data in plot.beside or ()
    )


def _points(
    plot: PlotFile, data: BesideFile, folder: Path, unit_on: Callable[[str], str]
) -> tuple[tuple[float, ...], ...]:
    """Return the points of one data set."""
    if data.points:
        return tuple(map(tuple, data.points))
    table = read_measured(folder / data.file)
    columns = [_column(plot, table, axis, getattr(data, axis), unit_on(axis)) for axis in "xy"]
    if data.yerr:
        columns.append(_errors(table, data.yerr, unit_on("y")))
    if data.line and len(table.lines) < 2:
        raise InputError.of_value(table.path, "", "1 row", "at least two rows for a line")
    return tuple(zip(*columns, strict=True))


def _column(
    plot: PlotFile, table: MeasuredTable, axis: str, name: str, unit: str
) -> tuple[float, ...]:
    """Return the numbers of a column on an axis with a unit."""
    table.require_column(name, f"for the axis {axis}")
    _require_no_unit(table, name, unit)
    allowed = (
        allowed_on_logarithmic(axis)
        if axis in plot.log
        else f"a number of size up to {MAX_MAGNITUDE:g}"
    )
    low = plot.least(axis)
    return table.numbers(name, unit or PURE, low=low, high=MAX_MAGNITUDE, allowed=allowed)


def _errors(table: MeasuredTable, name: str, unit: str) -> tuple[float, ...]:
    """Return the numbers of a column of errors."""
    table.require_column(name, "the errors of y")
    _require_no_unit(table, name, unit)
    allowed = f"an error in [0, {MAX_MAGNITUDE:g}]"
    return table.numbers(name, unit or PURE, low=0, high=MAX_MAGNITUDE, allowed=allowed)


def _require_no_unit(table: MeasuredTable, name: str, unit: str) -> None:
    """Raise ``InputError`` where a heading has a unit, but the axis a natural one."""
    if table.units[name] and not unit:
        allowed = "no unit, for a plot with units: natural"
        raise InputError.of_value(table.path, f"unit of column {name}", table.units[name], allowed)
