"""Rounds of refinement: the points that each adds to a study, and the files that list them."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.base.seals import checked_read
from sim.dataset.adopted import AdoptedPoints
from sim.dataset.boundary_side import side, side_of_run
from sim.parameters import Parameters, canonical_values, parse_point, point_id
from sim.study.expand import point_with_membership
from sim.study.load import Boundary, Study, load_study
from sim.study.refine import Sides, divide_range, next_values

#: Returns the side of a boundary that the run of a point is on, ``None`` where it is not known.
SideFinder = Callable[[Boundary, Parameters], str | None]


def read_round(path: Path) -> dict[str, Parameters]:
    """Read the points by id that a round has added; a damaged file is set aside.

    Raises
    ------
    InputError
        When there is no such file, or it is not a round.
    """
    with checked_read(path, "round of refinement", replaceable=True):
        mappings = json.loads(path.read_text(encoding="utf-8"))
        try:
            points = {key: parse_point(values, path) for key, values in mappings.items()}
        except InputError as error:
            raise ValueError(error) from None
        wrong = [key for key, point in points.items() if key != point_id(point)]
        if wrong:
            raise ValueError(f"{wrong[0]} is not the id of its point")
        return points


def round_files(study: Study, folder: Path) -> list[Path]:
    """Return the files of the finished rounds, given the results folder of the study."""
    files = (folder / "rounds" / f"{number}.json" for number in range(1, study.rounds + 1))
    return list(filter(Path.is_file, files))


def known_points(study: Study, folder: Path) -> dict[str, Parameters]:
    """Return the points of the study file and those that its finished rounds have added."""
    points = {key: point.parameters for key, point in study.points.items()}
    for path in round_files(study, folder):
        points |= read_round(path)
    return points


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
    text = json.dumps({key: canonical_values(point) for key, point in points.items()}, indent=1)
    output = folder / "rounds" / f"{number}.json"
    output.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(output) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")
    return output


def added_points(study: Study, number: int, runs: Path) -> dict[str, Parameters]:
    """Return the points by id that round ``number`` adds to all before it.

    They depend only on the run files in ``runs`` and on the adopted datasets in the folder next to
    it, so every call gives the same points.
    """
    earlier = set(study.points)
    added: dict[str, Parameters] = {}
    side_of = side_reader(study, runs)
    rounds = [list(_walk_rounds(boundary, number, side_of)) for boundary in study.boundaries]
    for step in range(1, number + 1):
        points = (
            boundary.parameters_at(value)
            for boundary, steps in zip(study.boundaries, rounds, strict=True)
            for value in steps[step][1]
        )
        by_id = {point_id(point): point for point in points}
        added = {key: point for key, point in by_id.items() if key not in earlier}
        earlier |= set(added)
    return added


def side_reader(study: Study, runs: Path) -> SideFinder:
    """Return a function that reads the side of a point from its run file in the folder ``runs``.

    For an adopted point it reads the side from the adopted dataset.
    """
    adopted = AdoptedPoints(study, runs.parent)

    def side_of(boundary: Boundary, point: Parameters) -> str | None:
        key, full_point = point_id(point), with_study_amounts(study, point)
        if row := adopted.source(key, full_point):
            return side(row.wanted_scalars(full_point), boundary.of, full_point)
        return side_of_run(runs / f"{key}.nc", boundary.of, full_point)

    return side_of


def with_study_amounts(study: Study, point: Parameters) -> Parameters:
    """Return a point of a boundary with the amounts of the study, whose series may ask for more."""
    member = study.points.get(point_id(point))
    return member.parameters if member else point


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


def _walk_rounds(
    boundary: Boundary, count: int, side_of: SideFinder
) -> Iterator[tuple[dict[float, str | None], list[float]]]:
    """Yield the sides known before each round, and the values that the round adds.

    The first round is that of the study file; ``count`` more follow. The runs of the last round are
    not read.
    """
    sides: dict[float, str | None] = {}
    values = divide_range(boundary.low, boundary.high)
    yield sides, values
    for _ in range(count):
        sides = sides | {
            value: side_of(boundary, boundary.parameters_at(value)) for value in values
        }
        values = next_values(sides, boundary.tolerance)
        yield sides, values


def find_sides(
    boundaries: Sequence[Boundary],
    side_of: SideFinder,
    read_runs: Callable[[list[Parameters]], object],
) -> list[Sides]:
    """Return the sides of the values of all rounds, for each boundary; the runs must be there.

    ``read_runs`` is called with the points of each round before ``side_of`` is called for any of
    them.
    """
    last_steps: dict[int, tuple[Sides, list[float]]] = {}
    for steps in zip_longest(
        *(_walk_rounds(boundary, boundary.rounds, side_of) for boundary in boundaries)
    ):
        last_steps |= {number: step for number, step in enumerate(steps) if step}
        pairs = zip(boundaries, steps, strict=True)
        new_values = ((boundary, step[1]) for boundary, step in pairs if step)
        read_runs([boundary.parameters_at(value) for boundary, new in new_values for value in new])
    sides_of_boundaries: list[Sides] = []
    for number, boundary in enumerate(boundaries):
        sides, values = last_steps[number]
        last_sides = {value: side_of(boundary, boundary.parameters_at(value)) for value in values}
        sides_of_boundaries.append({**sides, **last_sides})
    return sides_of_boundaries
