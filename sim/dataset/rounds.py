"""Rounds of refinement: which points each adds to a study, and the files that say so."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path

from sim.base.damage import checked_read
from sim.base.errors import InputError
from sim.base.files import replacing
from sim.dataset.adopted import Adopted
from sim.dataset.boundary_side import side, side_of_run
from sim.parameters import Parameters, canonical, parse_point, point_id
from sim.study.load import Boundary, Study, as_member, load_study
from sim.study.plots import points_shown
from sim.study.refine import Sides, divided, next_values

#: Tells on which side of a boundary the run of a point is.
SideOf = Callable[[Boundary, Parameters], str | None]


def read_round(path: Path) -> dict[str, Parameters]:
    """Read the points by id that a round has added; a damaged file is set aside.

    Raises
    ------
    InputError
        When there is no such file, or it is not one.
    """
    with checked_read(path, "round of refinement", replaceable=True):
        held = json.loads(path.read_text(encoding="utf-8"))
        try:
            points = {key: parse_point(values, path) for key, values in held.items()}
        except InputError as error:
            raise ValueError(error) from None
        wrong = [key for key, point in points.items() if key != point_id(point)]
        if wrong:
            raise ValueError(f"{wrong[0]} is not the id of its point")
        return points


def round_files(study: Study, folder: Path) -> list[Path]:
    """Return the files of the rounds that have been worked out, in the folder of the results."""
    files = (folder / "rounds" / f"{number}.json" for number in range(1, study.rounds + 1))
    return list(filter(Path.is_file, files))


def known_points(study: Study, folder: Path) -> dict[str, Parameters]:
    """Return the points of the study file and those that its rounds so far have added to them."""
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
    text = json.dumps({key: canonical(point) for key, point in points.items()}, indent=1)
    output = folder / "rounds" / f"{number}.json"
    output.parent.mkdir(parents=True, exist_ok=True)
    with replacing(output) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")
    return output


def added_points(study: Study, number: int, runs: Path) -> dict[str, Parameters]:
    """Return the points by id that round ``number`` adds to all before it.

    Which these are follows from the run files in ``runs``, and adopted datasets beside that folder,
    alone, however often it is asked.
    """
    seen = set(study.points)
    added: dict[str, Parameters] = {}
    side_of = from_files(study, runs)
    rounds = [list(_rounds(boundary, number, side_of)) for boundary in study.boundaries]
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


def from_files(study: Study, runs: Path) -> SideOf:
    """Return a function that reads the side of a point from its run file in the folder ``runs``.

    That of an adopted point is told by its dataset.
    """
    adopted = Adopted(study, runs.parent)

    def side_of(boundary: Boundary, point: Parameters) -> str | None:
        key, wanted = point_id(point), as_wanted(study, point)
        if held := adopted.source(key, wanted):
            return side(held.scalars_of(wanted), boundary.of, wanted)
        return side_of_run(runs / f"{key}.nc", boundary.of, wanted)

    return side_of


def as_wanted(study: Study, point: Parameters) -> Parameters:
    """Return a point of a boundary with as much of it as the study wants: series may want more."""
    known = study.points.get(point_id(point))
    return known.parameters if known else point


def refined(study: Study, found: Sequence[Sides]) -> Study:
    """Return the study with the points of all rounds, given the sides found of each boundary."""
    points, series = dict(study.points), dict(study.series)
    for boundary, sides in zip(study.boundaries, found, strict=True):
        for value in sides:
            point = as_member(points, boundary.at(value), boundary.name, boundary.figures)
            points[point.id] = point
            series[boundary.name] = tuple(dict.fromkeys((*series[boundary.name], point.id)))
    figures = {
        name: tuple(point.id for point in points.values() if name in point.figures)
        for name in study.figures
        if name not in study.plots
    }
    figures |= {name: points_shown(one, points.values()) for name, one in study.plots.items()}
    return replace(study, points=points, series=series, figures=figures)


def _rounds(
    boundary: Boundary, count: int, side_of: SideOf
) -> Iterator[tuple[dict[float, str | None], list[float]]]:
    """Yield what is known before each round and the values that it adds.

    The first round is the study's own; ``count`` more follow. The runs of the last are not read.
    """
    sides: dict[float, str | None] = {}
    values = divided(boundary.low, boundary.high)
    yield sides, values
    for _ in range(count):
        sides = sides | {value: side_of(boundary, boundary.at(value)) for value in values}
        values = next_values(sides, boundary.tolerance)
        yield sides, values


def sides_of(
    boundaries: Sequence[Boundary], side_of: SideOf, read: Callable[[list[Parameters]], object]
) -> list[Sides]:
    """Return the sides of all values of all rounds of boundaries, whose runs must be there.

    ``read`` is told of the points of each round before any of them is asked for its side.
    """
    known: dict[int, tuple[Sides, list[float]]] = {}
    for steps in zip_longest(*(_rounds(one, one.rounds, side_of) for one in boundaries)):
        known |= {number: step for number, step in enumerate(steps) if step}
        values = ((one, step[1]) for one, step in zip(boundaries, steps, strict=True) if step)
        read([boundary.at(value) for boundary, new in values for value in new])
    return [
        {**known[number][0], **{value: side_of(one, one.at(value)) for value in known[number][1]}}
        for number, one in enumerate(boundaries)
    ]
