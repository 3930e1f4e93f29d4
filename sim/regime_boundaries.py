"""Boundaries between regimes: which points a round of refinement adds, and what was found."""

import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

import netCDF4
import pandas as pd
import xarray as xr

from sim.base.errors import InputError
from sim.base.files import replacing
from sim.base.reading import reading
from sim.parameters import Parameters, canonical, field_info, point_id
from sim.sides import side_of_run
from sim.study.load import Boundary, Study, joined, load_study
from sim.study.refine import Sides, divided, located, next_values

#: Group of the dataset that holds what was found, one row per boundary.
GROUP = "boundaries"

_FOUND = ("low", "high", "below", "above", "verdict", "points")
_COLUMNS = ("name", "system", "of", "along", "unit", "figures", *_FOUND)


def write_round(study_path: str | Path, number: int, results: str | Path = "results") -> Path:
    """Write the points that a round of refinement adds to ``results/<study>/rounds/<number>.json``.

    Parameters
    ----------
    study_path : str or Path
        The study file.
    number : int
        Number of the round, from 1; the runs of all rounds before it must be there.
    results : str or Path
        Folder of all results.

    Returns
    -------
    Path
        The file written: parameters by id of the point. It appears complete or not at all.

    Raises
    ------
    InputError
        When the study has no such round, or a run file is missing or is not one.
    """
    study = load_study(study_path, results)
    if not 1 <= number <= study.rounds:
        allowed = f"a round of the study, 1 to {study.rounds}" if study.rounds else "none"
        raise InputError.of_value("ROUND", "", number, allowed)
    folder = Path(results) / study.name
    points = added_points(study, number, folder / "runs")
    text = json.dumps({key: canonical(point) for key, point in points.items()}, indent=1)
    output = folder / "rounds" / f"{number}.json"
    output.parent.mkdir(parents=True, exist_ok=True)
    with replacing(output) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")
    return output


def added_points(study: Study, number: int, runs: Path) -> dict[str, Parameters]:
    """Return the points by id that round ``number`` adds to all before it.

    Which these are follows from the run files in ``runs`` alone, however often it is asked.
    """
    seen, added = set(study.points), {}
    rounds = [list(_rounds(boundary, number, runs)) for boundary in study.boundaries]
    for each in range(1, number + 1):
        points = (
            boundary.at(value)
            for boundary, made in zip(study.boundaries, rounds, strict=True)
            for value in made[each][1]
        )
        named = {point_id(point): point for point in points}
        added = {key: point for key, point in named.items() if key not in seen}
        seen |= set(added)
    return added


def refined(study: Study, runs: Path) -> Study:
    """Return the study with the points of all rounds, whose runs must be there."""
    points, series = dict(study.points), dict(study.series)
    for boundary in study.boundaries:
        for value in _sides(boundary, runs):
            point = joined(points, boundary.at(value), boundary.name, boundary.figures)
            points[point.id] = point
            series[boundary.name] = tuple(dict.fromkeys((*series[boundary.name], point.id)))
    figures = {
        name: tuple(point.id for point in points.values() if name in point.figures)
        for name in study.figures
    }
    return replace(study, points=points, series=series, figures=figures)


def table(study: Study, runs: Path) -> pd.DataFrame:
    """Return one row per boundary: what it is, where it lies, and all numbers of its points.

    Returns
    -------
    pandas.DataFrame
        ``name``, ``system``, ``of``, ``along``, ``unit`` (of ``low`` and ``high``), ``figures``,
        ``low`` and ``high`` (NaN without a boundary in the range), ``below``, ``above``,
        ``verdict`` (see `sim.study.refine.Located`), ``points`` (their number), then the parameters
        of the point at the low end of the range; NaN or ``""`` for those of the other system.
    """
    rows = []
    for boundary in study.boundaries:
        sides = _sides(boundary, runs)
        start = boundary.at(boundary.low)
        declared = field_info(start)[boundary.along]
        settings = {
            name: value if isinstance(value, str) else float(value)
            for name, value in canonical(start).items()
        }
        what = {
            "name": boundary.name,
            "system": start.system,
            "of": boundary.of,
            "along": boundary.along,
            "unit": declared.scale or declared.unit,
            "figures": " ".join(boundary.figures),
        }
        found = asdict(located(sides, boundary.tolerance)) | {"points": len(sides)}
        rows.append(settings | what | found)
    table = pd.DataFrame(rows).astype({"low": float, "high": float}).rename_axis("boundary")
    words = table.select_dtypes(exclude="number").columns
    return table.fillna(dict.fromkeys(words, ""))


def read_table(dataset: Path) -> pd.DataFrame:
    """Read the table of boundaries from a study's dataset; without rows where there is none.

    Raises
    ------
    InputError
        When there is no dataset, or it is damaged. That of a study is then set aside.
    """
    with reading(dataset, "dataset", replaceable=is_of_study(dataset)):
        with netCDF4.Dataset(dataset) as file:
            if GROUP not in file.groups:
                return pd.DataFrame(columns=_COLUMNS)
        with xr.open_dataset(dataset, engine="netcdf4", group=GROUP) as found:
            return found.to_dataframe()


def is_of_study(dataset: Path) -> bool:
    """Return whether a dataset lies where the workflow makes it, beside its runs."""
    return dataset.name == "dataset.nc" and (dataset.parent / "runs").is_dir()


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
    return shown(study, rows).to_csv(index=False, float_format="%.10g")


def shown(study: Study, rows: pd.DataFrame) -> pd.DataFrame:
    """Return the columns of the table that a reader wants: those that grids vary among them.

    A parameter is blank for the boundaries along it.
    """
    varied = dict.fromkeys(name for boundary in study.boundaries for name in boundary.grid)
    blanked = {name: rows[name].mask(rows["along"] == name) for name in varied}
    return rows.assign(**blanked)[["name", "system", "of", *varied, "along", "unit", *_FOUND]]


def _rounds(boundary: Boundary, count: int, runs: Path) -> Iterator[tuple[Sides, list[float]]]:
    """Yield what is known before each round and the values that it adds.

    The first round is the study's own; ``count`` more follow. The runs of the last are not read.
    """
    sides: Sides = {}
    values = divided(boundary.low, boundary.high)
    yield sides, values
    for _ in range(count):
        sides = sides | _read(boundary, values, runs)
        values = next_values(sides, boundary.tolerance)
        yield sides, values


def _sides(boundary: Boundary, runs: Path) -> Sides:
    """Return the sides of all values of all rounds."""
    *_, (sides, values) = _rounds(boundary, boundary.rounds, runs)
    return sides | _read(boundary, values, runs)


def _read(boundary: Boundary, values: list[float], runs: Path) -> Sides:
    """Return the sides of some values from their runs."""
    points = {value: boundary.at(value) for value in values}
    return {
        value: side_of_run(runs / f"{point_id(point)}.nc", boundary.of, point)
        for value, point in points.items()
    }
