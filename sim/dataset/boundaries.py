"""Boundaries between regimes: their locations as a table and as CSV."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.dataset.results import RESULT_COLUMNS, read_table
from sim.parameters import complete_values, field_info
from sim.study.load import Study, load_study
from sim.study.refine import Sides, locate_boundary


def tabulate(study: Study, sides_of_boundaries: Sequence[Sides]) -> pd.DataFrame:
    """Return a table with one row per boundary: its definition, its location, its parameters.

    Parameters
    ----------
    study : Study
        The study with the boundaries.
    sides_of_boundaries : sequence of dict
        For each boundary the side of each value, by value.

    Returns
    -------
    pandas.DataFrame
        ``name``, ``system``, ``of``, ``along``, ``unit`` (of ``low`` and ``high``), ``figures``,
        ``low`` and ``high`` (NaN without a boundary in the range), ``below``, ``above``,
        ``verdict`` (see `sim.study.refine.BoundaryEstimate`), ``points`` (their number), then the
        parameters of the point at the low end of the range; NaN or ``""`` for parameters that only
        other systems have.
    """
    rows = []
    for boundary, sides in zip(study.boundaries, sides_of_boundaries, strict=True):
        start = boundary.parameters_at(boundary.low)
        declared = field_info(start)[boundary.along]
        settings = {
            name: value if isinstance(value, str) else float(value)
            for name, value in complete_values(start).items()
        }
        definition = {
            "name": boundary.name,
            "system": start.system,
            "of": boundary.of,
            "along": boundary.along,
            "unit": declared.scale or declared.unit,
            "figures": " ".join(boundary.figures),
        }
        location = asdict(locate_boundary(sides, boundary.tolerance)) | {"points": len(sides)}
        rows.append(settings | definition | location)
    table = pd.DataFrame(rows).astype({"low": float, "high": float}).rename_axis("boundary")
    text_columns = table.select_dtypes(exclude="number").columns
    return table.fillna(dict.fromkeys(text_columns, ""))


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Write ``results/<study>/boundaries.csv`` from the dataset of a study.

    Returns
    -------
    Path
        The file written: one row per boundary. It appears complete or not at all.

    Raises
    ------
    InputError
        When the study has no boundaries, or the dataset is missing.
    """
    study = load_study(study_path, results)
    if not study.boundaries:
        allowed = "a study with boundaries"
        raise InputError.of_value(study_path, "boundaries", None, allowed)
    folder = Path(results) / study.name
    output = folder / "boundaries.csv"
    with atomic_write(output) as temporary:
        text = format_csv(study, read_table(folder / "dataset.nc"))
        temporary.write_text(text, encoding="utf-8")
    return output


def format_csv(study: Study, rows: pd.DataFrame) -> str:
    """Return the text of ``boundaries.csv``."""
    return csv_columns(study, rows).to_csv(index=False, float_format="%.10g")


def csv_columns(study: Study, rows: pd.DataFrame) -> pd.DataFrame:
    """Return the columns of ``boundaries.csv``, among them the parameters that grids vary.

    A parameter is blank in the rows of boundaries along it.
    """
    varied = dict.fromkeys(name for boundary in study.boundaries for name in boundary.grid)
    blanked = {name: rows[name].mask(rows["along"] == name) for name in varied}
    return rows.assign(**blanked)[
        ["name", "system", "of", *varied, "along", "unit", *RESULT_COLUMNS]
    ]
