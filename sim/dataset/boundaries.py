"""Boundaries between regimes: their rounds of refinement, and their locations as a table."""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.dataset.rounds import RESULT_COLUMNS, side_of_run
from sim.parameters import Parameters, complete_values, field_info, point_id
from sim.study.expand import point_with_membership
from sim.study.load import Boundary, Study, load_study
from sim.study.model import Sides, divide_range, locate_boundary, next_values

if TYPE_CHECKING:
    # Imported in functions otherwise: rounds of refinement need no table library.
    import pandas as pd


def added_points(study: Study, number: int, runs: Path) -> dict[str, Parameters]:
    """Return the points by id that round ``number`` adds to all before it.

    They depend only on the run files in ``runs``, so every call gives the same points.
    """
    earlier = set(study.points)
    added: dict[str, Parameters] = {}
    rounds = [_walk(study, runs, boundary, number)[1] for boundary in study.boundaries]
    for step in range(1, number + 1):
        points = (
            boundary.parameters_at(value)
            for boundary, values in zip(study.boundaries, rounds, strict=True)
            for value in values[step]
        )
        by_id = {point_id(point): point for point in points}
        added = {key: point for key, point in by_id.items() if key not in earlier}
        earlier |= set(added)
    return added


def find_sides(study: Study, runs: Path) -> list[Sides]:
    """Return the sides of the values of all rounds, for each boundary; the runs must be there.

    They are read as those of `added_points` are.
    """
    return [_walk(study, runs, one, one.rounds + 1)[0] for one in study.boundaries]


def _walk(
    study: Study, runs: Path, boundary: Boundary, count: int
) -> tuple[Sides, list[list[float]]]:
    """Return the sides known after ``count`` rounds, and the values that each of them adds.

    The first round is that of the study file. One more round of values follows from the sides.
    """
    sides: dict[float, str | None] = {}
    rounds = [divide_range(boundary.low, boundary.high)]
    for _ in range(count):
        problems = []
        for value in rounds[-1]:
            point = boundary.parameters_at(value)
            key = point_id(point)
            # A series of the study may ask for more of the point.
            point = study.points[key].parameters if key in study.points else point
            try:
                sides[value] = side_of_run(runs / f"{key}.nc", boundary.of, point)
            except InputError as error:
                problems.append(str(error))
        if problems:
            raise InputError.of_several(problems)
        rounds.append(next_values(sides, boundary.tolerance))
    return sides, rounds


def add_rounds(study: Study, sides_of_boundaries: Sequence[Sides]) -> Study:
    """Return the study with the points of all rounds, given the known sides of each boundary."""
    points, series = dict(study.points), dict(study.series)
    for boundary, sides in zip(study.boundaries, sides_of_boundaries, strict=True):
        for value in sides:
            point = point_with_membership(
                points, boundary.parameters_at(value), boundary.name, boundary.figures
            )
            points[point.id] = point
            series[boundary.name] = tuple(dict.fromkeys((*series[boundary.name], point.id)))
    return replace(study, points=points, series=series)


def tabulate(study: Study, sides_of_boundaries: Sequence[Sides]) -> "pd.DataFrame":
    """Return a table with one row per boundary: its definition, its location, its parameters.

    ``sides_of_boundaries`` has for each boundary the side of each value, by value. Columns are
    ``name``, ``system``, ``of``, ``along``, ``unit`` (of ``low`` and ``high``), ``figures``,
    ``low`` and ``high`` (NaN without a boundary in the range), ``below``, ``above``, ``verdict``
    (see `sim.study.model.BoundaryEstimate`), ``points`` (their number), then the parameters of the
    point at the low end of the range; NaN or ``""`` for parameters that only other systems have.
    """
    import pandas as pd

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

    The file has one row per boundary; it appears complete or not at all. Raises `InputError` when
    the study has no boundaries, or the dataset is missing.
    """
    from sim.dataset.results import load_results

    study = load_study(study_path, results)
    if not study.boundaries:
        allowed = "a study with boundaries"
        raise InputError.of_value(study_path, "boundaries", None, allowed)
    folder = Path(results) / study.name
    output = folder / "boundaries.csv"
    with atomic_write(output) as temporary:
        text = format_csv(study, load_results(folder / "dataset.nc").boundaries)
        temporary.write_text(text, encoding="utf-8")
    return output


def format_csv(study: Study, rows: "pd.DataFrame") -> str:
    """Return the text of ``boundaries.csv``: results, and the parameters that grids vary.

    A parameter is blank in the rows of boundaries along it.
    """
    varied = dict.fromkeys(name for boundary in study.boundaries for name in boundary.grid)
    blanked = {name: rows[name].mask(rows["along"] == name) for name in varied}
    columns = ["name", "system", "of", *varied, "along", "unit", *RESULT_COLUMNS]
    return rows.assign(**blanked)[columns].to_csv(index=False, float_format="%.10g")
