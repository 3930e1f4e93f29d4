"""Boundaries between regimes: what was found of each, as a table and as CSV."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from sim.base.errors import InputError
from sim.base.files import replacing
from sim.dataset.boundary_table import FOUND, read_table
from sim.parameters import complete, field_info
from sim.study.load import Study, load_study
from sim.study.refine import Sides, located


def table(study: Study, found: Sequence[Sides]) -> pd.DataFrame:
    """Return one row per boundary: what it is, where it lies, and all numbers of its points.

    Parameters
    ----------
    study : Study
        Has the boundaries.
    found : sequence of dict
        The side of each value of each boundary.

    Returns
    -------
    pandas.DataFrame
        ``name``, ``system``, ``of``, ``along``, ``unit`` (of ``low`` and ``high``), ``figures``,
        ``low`` and ``high`` (NaN without a boundary in the range), ``below``, ``above``,
        ``verdict`` (see `sim.study.refine.Located`), ``points`` (their number), then the parameters
        of the point at the low end of the range; NaN or ``""`` for those of the other system.
    """
    rows = []
    for boundary, sides in zip(study.boundaries, found, strict=True):
        start = boundary.at(boundary.low)
        declared = field_info(start)[boundary.along]
        settings = {
            name: value if isinstance(value, str) else float(value)
            for name, value in complete(start).items()
        }
        what = {
            "name": boundary.name,
            "system": start.system,
            "of": boundary.of,
            "along": boundary.along,
            "unit": declared.scale or declared.unit,
            "figures": " ".join(boundary.figures),
        }
        place = asdict(located(sides, boundary.tolerance)) | {"points": len(sides)}
        rows.append(settings | what | place)
    table = pd.DataFrame(rows).astype({"low": float, "high": float}).rename_axis("boundary")
    words = table.select_dtypes(exclude="number").columns
    return table.fillna(dict.fromkeys(words, ""))


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Write ``results/<study>/boundaries.csv`` from the dataset of a study.

    Returns
    -------
    Path
        The file written: one row per boundary. It appears complete or not at all.

    Raises
    ------
    InputError
        When the study asks for no boundary, or the dataset is missing.
    """
    study = load_study(study_path, results)
    if not study.boundaries:
        allowed = "a study with boundaries"
        raise InputError.of_value(study_path, "boundaries", None, allowed)
    folder = Path(results) / study.name
    output = folder / "boundaries.csv"
    with replacing(output) as temporary:
        text = as_csv(study, read_table(folder / "dataset.nc"))
        temporary.write_text(text, encoding="utf-8")
    return output


def as_csv(study: Study, rows: pd.DataFrame) -> str:
    """Return the text of ``boundaries.csv``."""
    return reader_columns(study, rows).to_csv(index=False, float_format="%.10g")


def reader_columns(study: Study, rows: pd.DataFrame) -> pd.DataFrame:
    """Return the columns of the table that a reader wants: those that grids vary among them.

    A parameter is blank for the boundaries along it.
    """
    varied = dict.fromkeys(name for boundary in study.boundaries for name in boundary.grid)
    blanked = {name: rows[name].mask(rows["along"] == name) for name in varied}
    return rows.assign(**blanked)[["name", "system", "of", *varied, "along", "unit", *FOUND]]
