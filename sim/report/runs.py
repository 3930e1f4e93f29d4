"""Rows of the tables of runs, boundaries and parameters, counts of points, and a run as text."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.dataset.replicates import UNSOUND_SHARE, caveats, layer_orders, outcomes
from sim.engine.stored_run import open_run_file, parameters_of, summary_of
from sim.figures.caption import label_with_unit, unit_of
from sim.parameters import SYSTEMS, Parameters, as_yaml, complete_values, default_of, field_info
from sim.parameters.laws import FUNCTION_NAME as FUNCTION
from sim.parameters.roles import amount_parameters, numerical_parameters
from sim.parameters.variables import SCALARS, VARIABLES, observable_variables
from sim.parameters.words import setting
from sim.report.numbers import finite_or_none, template, value_with_interval
from sim.study.load import Study

#: Most columns of parameters in the table of points.
MOST_VARIED = 6

#: Regimes of points whose runs are too short to decide, or contradict each other.
OPEN_REGIMES = ("undetermined", "mixed")

#: The parameter that makes time steps shorter, by system.
SHORTER_STEPS = {
    "chute": "steps_per_collision",
    "belt": "steps_per_cycle",
    "conveyor": "steps_per_collision",
}


def run_rows(dataset: xr.Dataset, caveats: Sequence[str]) -> list[dict[str, Any]]:
    """Return one row per point: length of its runs, results and cost.

    ``number`` counts the points from 1. ``caveat`` is the number of its text in ``caveats``, from
    1, or 0 without one. ``samples`` is the number of independent samples behind the mean velocity.
    Unknown numbers are NaN.
    """
    # Not every engine tells all, and a function none of it.
    overlap, energy, samples = (
        dataset.get(name, dataset["steps"] * np.nan)
        for name in ("max_overlap", "missing_energy", "independent_samples")
    )
    names = ("point", "system", "protocol", "series", "replicates", "caveat")
    table = pd.DataFrame(
        {name: dataset[name].values for name in names}
        | {
            "wall_time": dataset["wall_time"].sum("replicate").values,
            "max_overlap": overlap.max("replicate").values,
            "missing_energy": energy.max("replicate").values,
            "samples": samples.sum("replicate", min_count=1).values,
        }
    )
    table["replicates"] = table["replicates"].astype(int)
    table["series"] = table["series"].str.split()
    table["caveat"] = [caveats.index(text) + 1 if text else 0 for text in table["caveat"]]
    table.insert(0, "number", range(1, len(table) + 1))
    rows = list[dict[str, Any]]()
    records: Any = table.to_dict("records")
    for row, outcome in zip(records, outcomes(dataset), strict=True):
        known = map(finite_or_none, (outcome["velocity"], outcome["half_width"]))
        rows.append(row | {"measured": value_with_interval(*known)} | outcome)
    return rows


def boundary_rows(study: Study, boundaries: pd.DataFrame) -> list[dict[str, Any]]:
    """Return one row per boundary for the table of boundaries, its position in the grid as text."""
    rows = boundaries.to_dict("records")
    for row, boundary in zip(rows, study.boundaries, strict=True):
        row["at"] = "; ".join(
            setting(row["system"], name, value) for name, value in boundary.grid.items()
        )
        row["unit"] = _unit_text(row["unit"])
        row["tolerance"] = boundary.tolerance
    return rows


def varied_columns(
    dataset: xr.Dataset, varied: Mapping[str, Mapping[str, np.ndarray]]
) -> tuple[list[dict[str, Any]], list[str]]:
    """Return columns for the table of points, and per point the settings that have no column.

    Columns are the parameters that vary, at most `MOST_VARIED`: first those of the physics, and of
    these the ones that most points set to another value than the commonest. Their ``texts`` are the
    values, one per point, empty where the system of a point has no such parameter. The settings are
    words on all other parameters that vary, where a point differs from the commonest value.
    ``varied`` is what `varied_parameters` returns.
    """
    columns: dict[str, dict[str, Any]] = {}
    settings: dict[str, list[str]] = {}
    for system, values_by_name in varied.items():
        indices = (dataset["system"] == system).values.nonzero()[0]
        for name, values in values_by_name.items():
            declared, is_number = field_info(SYSTEMS[system])[name], values.dtype.kind == "f"
            unit = declared.scale or declared.unit_text.strip()
            heading = label_with_unit(declared.symbol or name, unit)
            empty = [""] * dataset.sizes["point"]
            column = columns.setdefault(
                name, {"heading": heading, "number": is_number, "texts": empty, "rank": [1, 0]}
            )
            words = settings.setdefault(name, list(empty))
            commonest, count = Counter(values.tolist()).most_common(1)[0]
            column["rank"][0] = min(column["rank"][0], declared.role == "numerics")
            column["rank"][1] -= len(values) - count
            for index, value in zip(indices, values.tolist(), strict=True):
                column["texts"][index] = f"{value:.6g}" if is_number else str(value)
                words[index] = "" if value == commonest else setting(system, name, value)
    first = sorted(columns, key=lambda name: columns[name]["rank"])[:MOST_VARIED]
    rest = [texts for name, texts in settings.items() if name not in first]
    return (
        [column for name, column in columns.items() if name in first],
        [", ".join(filter(None, words)) for words in zip(*rest, strict=True)]
        or [""] * dataset.sizes["point"],
    )


def varied_parameters(dataset: xr.Dataset) -> dict[str, dict[str, np.ndarray]]:
    """Return the parameters that vary independently of others, by system.

    Each has its values, one per point of the system. Amounts, and what only asks for observables,
    are left out.
    """
    tables = {}
    for system, model in SYSTEMS.items():
        points = dataset.isel(point=(dataset["system"] == system).values)
        columns = {name: points[name].values for name in model.model_fields if name in points}
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        asking = {variable.asked_by for variable in VARIABLES} & numerical_parameters(model)
        left_out = {*amount_parameters(model), *asking}
        if rows:
            tables[system] = {
                name: values
                for name, values in columns.items()
                if name not in left_out
                and len(set(values.tolist())) > 1
                and not all(row[name] == default_of(model, name, row) for row in rows)
            }
    return tables


def parameter_rows(dataset: xr.Dataset, units: str = "si") -> dict[str, list[dict[str, Any]]]:
    """Return the parameters of each system in the study with the values they take."""
    tables = {}
    for system, model in SYSTEMS.items():
        points = dataset.isel(point=(dataset["system"] == system).values)
        if points.sizes["point"]:
            tables[system] = [
                {
                    "name": name,
                    "symbol": row.symbol,
                    "unit": row.scale or unit_of(row.unit, units, system)
                    if units == "natural"
                    else row.scale or _unit_text(row.unit),
                    "description": row.description,
                    "values": _values(points[name].values.tolist(), model, name),
                }
                for name, row in field_info(model).items()
                if name != "system"
            ]
    return tables


def _unit_text(unit: str) -> str:
    return "" if unit == "1" else unit


def _values(values: Sequence[Any], model: type[Parameters], name: str) -> str:
    """List distinct values in order: numbers with up to six digits, Booleans as true or false."""
    distinct = sorted(set(values))
    if model.model_fields[name].annotation is bool:
        return ", ".join("true" if value else "false" for value in distinct)
    return ", ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in distinct)


def state_of(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return counts of the points of a table of runs by result, and advice.

    Numbers of ``points``: all, ``completed`` with at least one replicate, ``failed``,
    ``undetermined``, ``mixed``, whose replicates contradict each other, and ``unsound``, whose
    energies do not add up. ``worst`` is the row of the worst unsound point, and ``advice`` the
    parameter that improves it. ``longer`` are the amounts that make runs of undetermined or
    mixed points longer, so that stored runs are kept, and ``drifting`` of these points drift.
    """
    undecided = [run for run in runs if run["regime"] in OPEN_REGIMES]
    unsound = [run for run in runs if run["missing_energy"] > UNSOUND_SHARE]
    worst = max(unsound, key=lambda run: run["missing_energy"], default=None)
    failed = sum(run["regime"] == "failed" for run in runs)
    longer = {
        "average"
        if run["protocol"] == "published"
        else "limit"
        if "limit" in run["stopped"]
        else "target"
        for run in undecided
    }
    return {
        "points": len(runs),
        "completed": len(runs) - failed,
        "failed": failed,
        **{name: sum(run["regime"] == name for run in undecided) for name in OPEN_REGIMES},
        "longer": sorted(longer),
        "drifting": sum(run["quality"] == "drifting" for run in undecided),
        "unsound": len(unsound),
        "worst": worst,
        "advice": SHORTER_STEPS[worst["system"]] if worst else "",
    }


#: Attributes of a run file that tell its origin.
_PROVENANCE = (
    *("engine_version", "numerics", "source_hash"),
    *("created", "versions", "machine", "command"),
)


def describe_run(path: Path, as_point: bool = False) -> str:
    """Return what a run file holds, or with ``as_point`` the text of the point file that makes it.

    Raises `InputError` when there is no such file, or it is not a run file.
    """
    with open_run_file(path) as file:
        parameters = parameters_of(file, path)
        if as_point:
            return as_yaml(parameters).rstrip()
        run = summary_of(path)
        scalars = run.scalars | {"layer_order": layer_orders(path, parameters)}
        known = {name: file.getncattr(name) for name in file.ncattrs()}
        known["caveat"] = caveats(run.attrs.get("caveat", ""), scalars, parameters)
        sizes = [f"{name} {len(one)}" for name, one in file.dimensions.items()]
        tables = {
            "parameters": _parameter_rows(parameters),
            "replicates": _replicate_rows(file),
            "provenance": [(name, known[name]) for name in _PROVENANCE if name in known],
        }
    page = {"known": known, "parameters": parameters, "sizes": sizes, "tables": tables}
    return template("run.txt.j2").render(page).rstrip()


def _parameter_rows(parameters: Parameters) -> list[tuple[str, str]]:
    values, rows = complete_values(parameters), []
    for name, row in field_info(parameters).items():
        value, unit = values[name], row.scale or row.unit
        text = f"{value:g}" if isinstance(value, float) else json.dumps(value).strip('"')
        rows.append((name, text if unit in ("", "1") else f"{text} {unit}"))
    limits = parameters.limits.items()
    return rows + [(name, f"{value:.6g} m s-2") for name, (value, _) in limits]


def _replicate_rows(file: netCDF4.Dataset) -> list[tuple[str, str]]:
    rows = []
    for name in (*SCALARS, *observable_variables(FUNCTION)):
        if name != "replicate_seed" and name in file.variables:
            variable = file.variables[name]
            values = [v if isinstance(v, str) else f"{v:.6g}" for v in variable[:].tolist()]
            unit = getattr(variable, "units", "")
            if any(values):
                heading = name if unit in ("", "1") else f"{name} ({unit})"
                rows.append((heading, " | ".join(values)))
    return rows
