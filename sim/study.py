"""From a study file to its points: which parameters, in which series, for which figures."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Any

from sim.cost import Estimate, estimate
from sim.errors import InputError
from sim.figures import FIGURES
from sim.folders import require_writable
from sim.parameters import Parameters, parse_point, point_id
from sim.study_file import BeltSeries, ChuteSeries, StudyFile, validated
from sim.yaml_input import read_yaml

__all__ = ["Estimate", "Point", "Study", "estimate", "load_study", "parse_study"]

MAX_POINTS = 100_000

#: The study that is meant when none is named.
DEFAULT_STUDY = Path("config/quick.yaml")

SeriesFile = ChuteSeries | BeltSeries


@dataclass(frozen=True)
class Point:
    """One run of a study, however many series and figures it serves."""

    id: str
    parameters: Parameters
    series: tuple[str, ...]
    figures: tuple[str, ...]


@dataclass(frozen=True)
class Study:
    """A validated study.

    Attributes
    ----------
    name, title : str
        Name of the folder of results; one line for the report.
    path : Path
        The study file.
    points : dict
        Points by id, in the order of the file; equal points of several series appear once.
    series, figures : dict
        Ids of the points of each series and of each figure, in order.
    """

    name: str
    title: str
    path: Path
    points: dict[str, Point]
    series: dict[str, tuple[str, ...]]
    figures: dict[str, tuple[str, ...]]


@dataclass
class _Draft:
    """Values of one point while they are collected, and where each stands in the file."""

    values: dict[str, Any] = field(default_factory=dict)
    paths: dict[str, str] = field(default_factory=dict)

    def with_values(self, values: dict[str, Any], path: str) -> "_Draft":
        """Return a copy in which ``values``, given at ``path``, replace earlier ones."""
        paths = {name: f"{path}.{name}" for name in values}
        return _Draft(self.values | values, self.paths | paths)


def load_study(path: str | Path, results: str | Path = "results") -> Study:
    """Read a study file and work out its points.

    Parameters
    ----------
    path : str or Path
        The study file.
    results : str or Path
        Folder that the study's own folder of results is, or will be, in.

    Raises
    ------
    InputError
        For anything that would keep the study from being run as written.
    """
    return parse_study(read_yaml(path), path, results)


def parse_study(mapping: Any, path: str | Path, results: str | Path = "results") -> Study:
    """Work out the points of the study that ``mapping``, read from ``path``, describes.

    See `load_study`.
    """
    source = str(path)
    file = validated(mapping, source)
    _require_distinct_names(file, source)
    _require_feasible_number(file, source)
    points: dict[str, Point] = {}
    series: dict[str, tuple[str, ...]] = {}
    for index, one in enumerate(file.series):
        ids = [_add(points, one, draft, source) for draft in _drafts(file, index, source)]
        series[one.name] = tuple(dict.fromkeys(ids))
    figures = _figures(file, points, source)
    require_writable(Path(results) / file.study, f"{source}: study")
    return Study(file.study, file.title, Path(path), points, series, figures)


def _require_distinct_names(file: StudyFile, source: str) -> None:
    seen: set[str] = set()
    for index, one in enumerate(file.series):
        if one.name in seen:
            allowed = "a name that no other series has"
            raise InputError.of_value(source, f"series[{index}].name", one.name, allowed)
        seen.add(one.name)


def _require_feasible_number(file: StudyFile, source: str) -> None:
    """Refuse too many points before a single one is made."""
    total = 0
    for index, one in enumerate(file.series):
        lists = one.grid.given().values() if one.grid else []
        count = prod(map(len, lists)) if lists else 0
        total += count + len(one.cases or [])
        if total > MAX_POINTS:
            allowed = f"at most {MAX_POINTS:,} points in the study"
            raise InputError.of_value(source, f"series[{index}].grid", f"{total:,} points", allowed)


def _drafts(file: StudyFile, index: int, source: str) -> Iterator[_Draft]:
    """Yield the points of one series, overrides applied: the grid first, then the cases."""
    one, path = file.series[index], f"series[{index}]"
    draft = _Draft({"system": one.system}, {"system": f"{path}.system"})
    shared = getattr(file.defaults, one.system)
    if shared:
        draft = draft.with_values(shared.given(), f"defaults.{one.system}")
    if one.base:
        draft = draft.with_values(one.base.given(), f"{path}.base")
    for start in _starts(one, draft, path):
        yield _overridden(one, start, path, source)


def _starts(one: SeriesFile, draft: _Draft, path: str) -> Iterator[_Draft]:
    """Yield the points of a series before its overrides."""
    if one.grid:
        lists = one.grid.given()
        for chosen in itertools.product(*(enumerate(values) for values in lists.values())):
            places = dict(zip(lists, chosen, strict=True))
            yield _Draft(
                draft.values | {name: value for name, (_, value) in places.items()},
                draft.paths | {name: f"{path}.grid.{name}[{i}]" for name, (i, _) in places.items()},
            )
    for index, case in enumerate(one.cases or []):
        yield draft.with_values(case.given(), f"{path}.cases[{index}]")
    if not one.grid and not one.cases:
        yield draft


def _overridden(one: SeriesFile, draft: _Draft, path: str, source: str) -> _Draft:
    """Apply the overrides whose conditions the point meets, later ones last.

    Conditions look at the point as it is before any override, omitted parameters included.
    """
    if not one.overrides:
        return draft
    before = parse_point(draft.values, source, draft.paths)
    for index, override in enumerate(one.overrides):
        wanted = override.when.given()
        if all(getattr(before, name) in values for name, values in wanted.items()):
            draft = draft.with_values(override.set.given(), f"{path}.overrides[{index}].set")
    return draft


def _add(points: dict[str, Point], one: SeriesFile, draft: _Draft, source: str) -> str:
    """Validate a point and add it, or its series and figures, to ``points``; return its id."""
    parameters = parse_point(draft.values, source, draft.paths)
    key = point_id(parameters)
    known = points.get(key, Point(key, parameters, (), ()))
    if known.parameters != parameters:
        raise InputError(f"{source}: two different points have the id {key}; change either's seed")
    points[key] = Point(
        key,
        parameters,
        tuple(dict.fromkeys((*known.series, one.name))),
        tuple(dict.fromkeys((*known.figures, *one.figures))),
    )
    return key


def _figures(file: StudyFile, points: dict[str, Point], source: str) -> dict[str, tuple[str, ...]]:
    """Collect the points of each figure, and refuse a figure that misses its series."""
    feeding = {
        name: f"series[{index}].figures[{place}]"
        for index, one in reversed(list(enumerate(file.series)))
        for place, name in enumerate(one.figures)
    }
    for place, name in enumerate(file.figures or []):
        if name not in feeding:
            allowed = "a figure that a series of the study feeds"
            raise InputError.of_value(source, f"figures[{place}]", name, allowed)
    figures = {}
    for name in FIGURES:
        if name not in feeding:
            continue
        if file.figures is not None and name not in file.figures:
            allowed = "a figure that the study lists under figures"
            raise InputError.of_value(source, feeding[name], name, allowed)
        members = [point for point in points.values() if name in point.figures]
        _require_axes(name, members, source, feeding[name])
        figures[name] = tuple(point.id for point in members)
    return figures


def _require_axes(name: str, members: list[Point], source: str, path: str) -> None:
    for axis in FIGURES[name].axes:
        values = {getattr(point.parameters, axis) for point in members}
        if len(values) < 2:
            got = f"{name} with {axis} = {values.pop():g} alone"
            axes = ", ".join(FIGURES[name].axes)
            allowed = f"series that feed {name} and together vary {axes}"
            raise InputError.of_value(source, path, got, allowed)
