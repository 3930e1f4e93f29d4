"""From one validated study file to its points and boundaries."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.parameters import Parameters, amounts, more, point_id, roles
from sim.study.catalogue import FIGURES
from sim.study.entries import BoundaryFile, SeriesFile
from sim.study.file import StudyFile, validated
from sim.study.model import Boundary, Point, Study
from sim.study.refine import PARTS, divided, further_rounds
from sim.study.series import Draft, finished, starts

MAX_POINTS = 100_000

#: Where each figure is fed: name -> (study file, key).
Fed = dict[str, tuple[str, str]]


def collected(mapping: Any, path: Path) -> tuple[StudyFile, Study, Fed]:
    """Return a study file, the study without its parts and figures, and where it feeds those."""
    source = str(path)
    file = validated(mapping, source)
    _require_distinct_names(file, source)
    _require_feasible_number(file, source)
    points: dict[str, Point] = {}
    series: dict[str, tuple[str, ...]] = {}
    for place, one in _entries(file, "series"):
        members = [
            (finished(one, draft, place, source), _fed(one.figures, draft))
            for draft in starts(file, one, place)
        ]
        series[one.name] = _add(points, one, members, source)
    boundaries: list[Boundary] = []
    for place, one in _entries(file, "boundaries"):
        found = list(_boundaries(file, one, place, source))
        first = [each.at(value) for each in found for value in divided(each.low, each.high)]
        members = [(parameters, one.figures) for parameters in first]
        series[one.name] = _add(points, one, members, source)
        boundaries += found
    fed = {
        name: (source, f"{place}.figures[{index}]")
        for place, one in reversed(_entries(file, "series") + _entries(file, "boundaries"))
        for index, name in enumerate(one.figures)
    }
    study = Study(file.study, file.title, (path,), points, series, {}, tuple(boundaries))
    return file, study, fed


def _entries(file: StudyFile, key: str) -> list[tuple[str, Any]]:
    """Return the series or the boundaries of a study with their places in the file."""
    return [(f"{key}[{index}]", one) for index, one in enumerate(getattr(file, key) or [])]


def _require_distinct_names(file: StudyFile, source: str) -> None:
    seen: set[str] = set()
    for path, one in _entries(file, "series") + _entries(file, "boundaries"):
        if one.name in seen:
            allowed = "a name that no other series has"
            raise InputError.of_value(source, f"{path}.name", one.name, allowed)
        seen.add(one.name)


def _require_feasible_number(file: StudyFile, source: str) -> None:
    """Refuse too many points before a single one is made."""
    total = 0
    for path, one in _entries(file, "series") + _entries(file, "boundaries"):
        lists = one.grid.given().values() if one.grid else []
        if isinstance(one, SeriesFile):
            read = getattr(file.readings, one.system)
            times = prod(map(len, read.given().values())) if read else 1
            total += times * ((prod(map(len, lists)) if lists else 0) + len(one.cases or []))
        else:
            total += prod(map(len, lists)) * _most_points(one)
        if total > MAX_POINTS:
            allowed = f"at most {MAX_POINTS:,} points in the study"
            raise InputError.of_value(source, f"{path}.grid", f"{total:,} points", allowed)


def _most_points(one: BoundaryFile) -> int:
    """Return how many points a boundary takes at most: two gaps are divided in every round."""
    low, high = one.range
    return PARTS + 1 + 2 * (PARTS - 1) * further_rounds(low, high, one.tolerance)


def _boundaries(file: StudyFile, one: BoundaryFile, path: str, source: str) -> Iterator[Boundary]:
    """Yield the boundaries of one entry, both ends of their ranges validated."""

    def point(start: Draft, value: float, place: str = "range") -> Parameters:
        there = Draft(
            start.values | {one.along: value}, start.paths | {one.along: f"{path}.{place}"}
        )
        return finished(one, there, path, source)

    for start in starts(file, one, path):
        for index, value in enumerate(one.range):
            point(start, value, f"range[{index}]")
        grid = {name: start.values[name] for name in one.grid.given()} if one.grid else {}
        yield Boundary(
            name=one.name,
            of=one.of,
            along=one.along,
            low=one.range[0],
            high=one.range[1],
            tolerance=one.tolerance,
            grid=grid,
            figures=tuple(one.figures),
            at=partial(point, start),
        )


def _fed(figures: Iterable[str], draft: Draft) -> list[str]:
    """Return the figures that a point feeds; under another reading, those with a curve for it."""
    return [name for name in figures if draft.other <= set(FIGURES[name].curves)]


def _add(
    points: dict[str, Point],
    one: SeriesFile | BoundaryFile,
    members: Iterable[tuple[Parameters, Iterable[str]]],
    source: str,
) -> tuple[str, ...]:
    """Add points with their figures, or series and figures, to ``points``; return their ids."""
    keys = {}
    for each, figures in members:
        point = as_member(points, each, one.name, figures)
        require_same(point, each, source)
        keys[point.id] = points[point.id] = point
    return tuple(keys)


def require_same(point: Point, parameters: Parameters, source: str) -> None:
    """Refuse parameters that have the id of another point; raises `InputError`."""
    usual = {name: getattr(point.parameters, name) for name in roles.amounts(type(parameters))}
    if parameters.model_copy(update=usual) != point.parameters:
        raise InputError(
            f"{source}: two different points have the id {point.id}; change either's seed"
        )


def as_member(
    points: dict[str, Point], parameters: Parameters, series: str, figures: Iterable[str]
) -> Point:
    """Return the point among ``points``, or a new one, as a member of a series and of figures.

    Of how much of it is asked in one place and in another, the more is run.
    Of the figures it joins those that show it; the others leave it out.
    """
    key = point_id(parameters)
    known = points.get(key, Point(key, parameters, (), ()))
    asked = dict.fromkeys((*known.figures, *known.left_out, *figures))
    shows = {name: FIGURES[name].shows(parameters) for name in asked}
    return replace(
        known,
        parameters=more(known.parameters, amounts(parameters)),
        series=tuple(dict.fromkeys((*known.series, series))),
        figures=tuple(name for name in asked if shows[name]),
        left_out=tuple(name for name in asked if not shows[name]),
    )
