"""The table of a study: a row per point, for spreadsheets and programs of statistics."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from sim.base.errors import InputError, count_text
from sim.base.files import atomic_write
from sim.base.measured import read_heading
from sim.base.messages import conversion
from sim.dataset.results import Results
from sim.figures.data import FigureData, figure_data, parameter_columns, varying_parameters
from sim.figures.plot import observed_quantity
from sim.parameters import SYSTEMS
from sim.parameters.variables import observable_variables
from sim.study.figure_spec import FigureSpec
from sim.study.plottable import Observable, find_observable, numbers

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

#: Formats of a table, which are the suffixes of its file.
TABLES = ("csv", "xlsx")

#: How names of errors end, which stand beside their value.
OF_ERRORS = ("_error", "_half_width")

#: Widest column of a sheet, in letters.
_WIDEST = 40


def points_of(results: Results, system: str, series: Sequence[str], shown: str) -> FigureData:
    """Return the points of some series of a system, for an observable that is shown of them."""
    keys: dict[str, Any] = {"kind": "curves", "system": system, "series": tuple(series)}
    return figure_data(results, FigureSpec.model_construct(name="points", y=shown, **keys))


def known_observables(results: Results, system: str) -> list[str]:
    """Return the observables of which some point has a value, the velocity first."""
    rows = results.of(system)
    found = [
        one.name
        for one in numbers(system).values()
        if one.source in rows
        and not one.name.endswith(OF_ERRORS)
        and rows[one.source].notnull().any()
    ]
    return sorted(found, key=lambda name: name != "velocity")


def point_table(
    results: Results, system: str, series: Sequence[str], asked: Sequence[str] = ()
) -> pd.DataFrame:
    """Return a row per point of some series: what varies, how sure it is, and observables.

    Each observable is a mean over replicates, with the half width of its 95 % interval beside it.
    ``asked`` names them, with a unit where it is not that of the dataset, as ``velocity (mm/s)``;
    by default, they are the velocity and all declared ones that have a value.

    Raises `InputError` for what is no observable of the system, or no unit of it.
    """
    data = points_of(results, system, series, "velocity")
    varied = varying_parameters(data.rows, list(SYSTEMS[system].model_fields))
    columns = parameter_columns(data.rows, system, varied)
    point = columns.pop("point")
    columns["regime"], columns["caveats"] = data.rows["regime"], data.rows["caveat"]
    columns["replicates"] = data.rows["completed"]
    known = known_observables(results, system)
    usual = [one for one in known if one in {"velocity", *observable_variables(system)}]
    for observable, unit in _asked(asked or usual, system):
        factor, named = conversion(observable.unit, unit) or 1.0, f"[{unit}]" if unit != "1" else ""
        spec = data.spec.model_copy(update={"y": observable.name})
        quantity = observed_quantity(replace(data, spec=spec))
        for name, values in (("", quantity.value), (" half width", quantity.half_width)):
            columns[f"{observable.name}{name} {named}".strip()] = factor * values
    return pd.DataFrame(columns | {"point": point}).reset_index(drop=True)


def _asked(texts: Iterable[str], system: str) -> list[tuple[Observable, str]]:
    """Return the observables that texts name, each with the unit that is asked for."""

    def error(key: str, value: Any, allowed: Any) -> InputError:
        return InputError.of_value("table", key, value, allowed)

    found = []
    for text in texts:
        name, unit = read_heading(text) or (text, "")
        observable = find_observable("curves", "observable", name, system, error)
        if unit and conversion(observable.unit, unit) is None:
            per_width = (
                ", which is per metre of width: kg/(m h)" if " m-1 s-1" in observable.unit else ""
            )
            allowed = f"a unit such as {observable.unit}{per_width}"
            raise error(f"unit of {name}", unit, allowed)
        found.append((observable, unit or observable.unit))
    return found


def write_table(rows: pd.DataFrame, to: str, output: Path) -> str:
    """Write a table as ``csv`` or ``xlsx``, and return a line on it."""
    output.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(output) as temporary:
        if to == "csv":
            rows.to_csv(temporary, index=False, float_format="%.10g")
        else:
            with pd.ExcelWriter(temporary, engine="openpyxl") as book:
                rows.to_excel(book, sheet_name="points", index=False, freeze_panes=(1, 0))
                _widen(book.sheets["points"])
    return f"{output}: {count_text(len(rows), 'point')}, {count_text(len(rows.columns), 'column')}"


def _widen(sheet: "Worksheet") -> None:
    """Make the columns of a sheet as wide as their headings."""
    for column in sheet.iter_cols(max_row=1):
        width = min(_WIDEST, len(str(column[0].value)) + 2)
        sheet.column_dimensions[column[0].column_letter].width = width
