"""Expand one validated study file to points and boundaries."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.parameters import Parameters, amounts, point_id, roles, with_larger_amounts
from sim.study.catalogue import FIGURES
from sim.study.entries import BoundaryFile, SeriesFile
from sim.study.file import StudyFile, validate_study
from sim.study.model import Boundary, Point, Study
from sim.study.refine import PARTS, divide_range, further_rounds
from sim.study.series import Draft, apply_overrides, make_drafts

MAX_POINTS = 100_000

#: Where a study feeds each figure: name of the figure → (study file, key).
FigureFeeds = dict[str, tuple[str, str]]


def expand_study_file(mapping: Any, path: Path) -> tuple[StudyFile, Study, FigureFeeds]:
    """Return a study file, its study without parts and figures, and where it feeds figures."""
    source = str(path)
    file = validate_study(mapping, source)
    _require_distinct_names(file, source)
    _require_feasible_number(file, source)
    points: dict[str, Point] = {}
    series: dict[str, tuple[str, ...]] = {}
    for key, entry in _paths_and_entries(file, "series"):
        members = [
            (apply_overrides(entry, draft, key, source), _figures_fed(entry.figures, draft))
            for draft in make_drafts(file, entry, key)
        ]
        series[entry.name] = _add_points(points, entry, members, source)
    boundaries: list[Boundary] = []
    for key, entry in _paths_and_entries(file, "boundaries"):
        entry_boundaries = list(_boundaries(file, entry, key, source))
        members = [
            (boundary.parameters_at(value), entry.figures)
            for boundary in entry_boundaries
            for value in divide_range(boundary.low, boundary.high)
        ]
        series[entry.name] = _add_points(points, entry, members, source)
        boundaries += entry_boundaries
    feeds = {
        name: (source, f"{key}.figures[{index}]")
        for key, entry in reversed(
            _paths_and_entries(file, "series") + _paths_and_entries(file, "boundaries")
        )
        for index, name in enumerate(entry.figures)
    }
    study = Study(file.study, file.title, (path,), points, series, {}, tuple(boundaries))
    return file, study, feeds


def _paths_and_entries(file: StudyFile, key: str) -> list[tuple[str, Any]]:
    """Return pairs of the key in the file and the entry, of all series or of all boundaries."""
    return [(f"{key}[{index}]", entry) for index, entry in enumerate(getattr(file, key) or [])]


def _require_distinct_names(file: StudyFile, source: str) -> None:
    names: set[str] = set()
    for path, entry in _paths_and_entries(file, "series") + _paths_and_entries(file, "boundaries"):
        if entry.name in names:
            allowed = "a name that no other series has"
            raise InputError.of_value(source, f"{path}.name", entry.name, allowed)
        names.add(entry.name)


def _require_feasible_number(file: StudyFile, source: str) -> None:
    """Raise ``InputError`` for too many points, before any point is made."""
    total = 0
    for path, entry in _paths_and_entries(file, "series") + _paths_and_entries(file, "boundaries"):
        lists = entry.grid.explicit_values().values() if entry.grid else []
        if isinstance(entry, SeriesFile):
            readings = getattr(file.readings, entry.system)
            number = prod(map(len, readings.explicit_values().values())) if readings else 1
            total += number * ((prod(map(len, lists)) if lists else 0) + len(entry.cases or []))
        else:
            total += prod(map(len, lists)) * _max_points(entry)
        if total > MAX_POINTS:
            allowed = f"at most {MAX_POINTS:,} points in the study"
            raise InputError.of_value(source, f"{path}.grid", f"{total:,} points", allowed)


def _max_points(entry: BoundaryFile) -> int:
    """Return the maximum number of points of a boundary: each round divides at most two gaps."""
    low, high = entry.range
    return PARTS + 1 + 2 * (PARTS - 1) * further_rounds(low, high, entry.tolerance)


def _boundaries(file: StudyFile, entry: BoundaryFile, path: str, source: str) -> Iterator[Boundary]:
    """Yield the boundaries of one entry, after validating both ends of their ranges."""

    def parameters_at(base: Draft, value: float, key: str = "range") -> Parameters:
        draft = Draft(
            base.values | {entry.along: value}, base.paths | {entry.along: f"{path}.{key}"}
        )
        return apply_overrides(entry, draft, path, source)

    for base in make_drafts(file, entry, path):
        for index, value in enumerate(entry.range):
            parameters_at(base, value, f"range[{index}]")
        grid = (
            {name: base.values[name] for name in entry.grid.explicit_values()} if entry.grid else {}
        )
        yield Boundary(
            name=entry.name,
            of=entry.of,
            along=entry.along,
            low=entry.range[0],
            high=entry.range[1],
            tolerance=entry.tolerance,
            grid=grid,
            figures=tuple(entry.figures),
            parameters_at=partial(parameters_at, base),
        )


def _figures_fed(figures: Iterable[str], draft: Draft) -> list[str]:
    """Return the figures that a point feeds; under another reading, those with a curve for that."""
    return [name for name in figures if draft.other_readings <= set(FIGURES[name].curves)]


def _add_points(
    points: dict[str, Point],
    entry: SeriesFile | BoundaryFile,
    members: Iterable[tuple[Parameters, Iterable[str]]],
    source: str,
) -> tuple[str, ...]:
    """Add ``members``, pairs of parameters and figures, to ``points``; return their ids."""
    ids = {}
    for parameters, figures in members:
        point = point_with_membership(points, parameters, entry.name, figures)
        require_same_point(point, parameters, source)
        ids[point.id] = points[point.id] = point
    return tuple(ids)


def require_same_point(point: Point, parameters: Parameters, source: str) -> None:
    """Raise `InputError` if parameters differ from a point of the same id in more than amounts."""
    same_amounts = {
        name: getattr(point.parameters, name) for name in roles.amount_parameters(type(parameters))
    }
    if parameters.model_copy(update=same_amounts) != point.parameters:
        raise InputError(
            f"{source}: two different points have the id {point.id}; change either's seed"
        )


def point_with_membership(
    points: dict[str, Point], parameters: Parameters, series: str, figures: Iterable[str]
) -> Point:
    """Return the point of ``parameters``, old or new, as a member of a series and of figures.

    Its amounts are the larger of the old and the new ones. It joins the figures that show it; the
    others leave it out.
    """
    key = point_id(parameters)
    point = points.get(key, Point(key, parameters, (), ()))
    names = dict.fromkeys((*point.figures, *point.left_out, *figures))
    shows = {name: FIGURES[name].shows(parameters) for name in names}
    return replace(
        point,
        parameters=with_larger_amounts(point.parameters, amounts(parameters)),
        series=tuple(dict.fromkeys((*point.series, series))),
        figures=tuple(name for name in names if shows[name]),
        left_out=tuple(name for name in names if not shows[name]),
    )
