"""From a study file to its points: which parameters, in which series, for which figures."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

from sim.cost import Estimate, estimate
from sim.drafts import BoundaryFile, Draft, SeriesFile, finished, starts
from sim.errors import InputError
from sim.figures import FIGURES
from sim.folders import require_writable
from sim.parameters import Parameters, point_id
from sim.refine import PARTS, divided, further_rounds
from sim.study_file import StudyFile, validated
from sim.yaml_input import read_yaml

__all__ = ["Boundary", "Estimate", "Point", "Study", "estimate", "load_study", "parse_study"]

MAX_POINTS = 100_000

#: The study that is meant when none is named.
DEFAULT_STUDY = Path("config/quick.yaml")


@dataclass(frozen=True)
class Point:
    """One run of a study, however many series and figures it serves."""

    id: str
    parameters: Parameters
    series: tuple[str, ...]
    figures: tuple[str, ...]


@dataclass(frozen=True)
class Boundary:
    """One boundary to be found, all parameters but one fixed.

    Attributes
    ----------
    name : str
        Shared by the boundaries of one entry of the study file, which its ``grid`` tells apart.
    of, along : str
        What changes at the boundary; the parameter along which it is looked for.
    low, high, tolerance : float
        Range of that parameter and width of the interval wanted.
    grid : dict
        Values of the grid that this boundary is for.
    figures : tuple of str
        Figures that it feeds.
    at : callable
        Gives the parameters of the point at a value of ``along``.
    """

    name: str
    of: str
    along: str
    low: float
    high: float
    tolerance: float
    grid: dict[str, Any]
    figures: tuple[str, ...]
    at: Callable[[float], Parameters]

    @property
    def rounds(self) -> int:
        """Rounds of refinement after the first."""
        return further_rounds(self.low, self.high, self.tolerance)


@dataclass(frozen=True)
class Study:
    """A validated study.

    Attributes
    ----------
    name, title : str
        Name of the folder of results; one line for the report.
    files : tuple of Path
        The study file, then those of its parts.
    points : dict
        Points by id, in the order of the file; equal points of several series appear once. Of the
        boundaries, the first round.
    series, figures : dict
        Ids of the points of each series (or boundary) and of each figure, in order.
    boundaries : tuple of Boundary
        Boundaries to be found.
    """

    name: str
    title: str
    files: tuple[Path, ...]
    points: dict[str, Point]
    series: dict[str, tuple[str, ...]]
    figures: dict[str, tuple[str, ...]]
    boundaries: tuple[Boundary, ...]

    @property
    def path(self) -> Path:
        """The study file."""
        return self.files[0]

    @property
    def rounds(self) -> int:
        """Rounds of refinement after the first that the boundaries may take."""
        return max((boundary.rounds for boundary in self.boundaries), default=0)


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
    source, folder = str(path), Path(path).parent
    file, study, fed = _collected(mapping, Path(path))
    for index, name in enumerate(file.parts or []):
        _, part, also = _collected(_part(folder / name, source, index), folder / name)
        study = _joined(study, part, f"{source}: parts[{index}]")
        fed = also | fed
    if len(study.points) > MAX_POINTS:
        allowed = f"at most {MAX_POINTS:,} points in the study"
        raise InputError.of_value(source, "parts", f"{len(study.points):,} points", allowed)
    figures = _figures(file, study.points, fed, source)
    require_writable(Path(results) / file.study, f"{source}: study")
    return replace(study, figures=figures)


#: Where each figure is fed: name -> (study file, key).
Fed = dict[str, tuple[str, str]]


def _collected(mapping: Any, path: Path) -> tuple[StudyFile, Study, Fed]:
    """Return a study file, the study without its parts and figures, and where it feeds those."""
    source = str(path)
    file = validated(mapping, source)
    _require_distinct_names(file, source)
    _require_feasible_number(file, source)
    points: dict[str, Point] = {}
    series: dict[str, tuple[str, ...]] = {}
    for place, one in _entries(file, "series"):
        parameters = [finished(one, draft, place, source) for draft in starts(file, one, place)]
        series[one.name] = _add(points, one, parameters, source)
    boundaries: list[Boundary] = []
    for place, one in _entries(file, "boundaries"):
        found = list(_boundaries(file, one, place, source))
        first = [each.at(value) for each in found for value in divided(each.low, each.high)]
        series[one.name] = _add(points, one, first, source)
        boundaries += found
    fed = {
        name: (source, f"{place}.figures[{index}]")
        for place, one in reversed(_entries(file, "series") + _entries(file, "boundaries"))
        for index, name in enumerate(one.figures)
    }
    study = Study(file.study, file.title, (path,), points, series, {}, tuple(boundaries))
    return file, study, fed


def _part(path: Path, source: str, index: int) -> Any:
    """Return the contents of a part, which has no parts of its own."""
    mapping = read_yaml(path)
    if isinstance(mapping, dict) and "parts" in mapping:
        allowed = "a study without parts of its own"
        raise InputError.of_value(source, f"parts[{index}]", path.name, allowed)
    return mapping


def _joined(study: Study, part: Study, source: str) -> Study:
    """Return a study with the points, series, boundaries and figures of a part as well."""
    for name in part.series:
        if name in study.series:
            allowed = "a part without a series of a name that another has"
            raise InputError.of_value(source, f"series {name}", part.path.name, allowed)
    points = dict(study.points)
    for one in part.points.values():
        for name in one.series:
            points[one.id] = joined(points, one.parameters, name, one.figures)
        _require_same(points[one.id], one.parameters, source)
    return replace(
        study,
        files=study.files + part.files,
        points=points,
        series=study.series | part.series,
        boundaries=study.boundaries + part.boundaries,
    )


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
            total += (prod(map(len, lists)) if lists else 0) + len(one.cases or [])
        else:
            total += prod(map(len, lists)) * _most_points(one)
        if total > MAX_POINTS:
            allowed = f"at most {MAX_POINTS:,} points in the study"
            raise InputError.of_value(source, f"{path}.grid", f"{total:,} points", allowed)


def _most_points(one: BoundaryFile) -> int:
    """Return how many points a boundary takes at most: two gaps are divided in every round."""
    return PARTS + 1 + 2 * (PARTS - 1) * further_rounds(*one.range, one.tolerance)


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


def _add(
    points: dict[str, Point],
    one: SeriesFile | BoundaryFile,
    parameters: Iterable[Parameters],
    source: str,
) -> tuple[str, ...]:
    """Add points, or their series and figures, to ``points``; return their ids."""
    keys = {}
    for each in parameters:
        point = joined(points, each, one.name, one.figures)
        _require_same(point, each, source)
        keys[point.id] = points[point.id] = point
    return tuple(keys)


def _require_same(point: Point, parameters: Parameters, source: str) -> None:
    if point.parameters != parameters:
        raise InputError(
            f"{source}: two different points have the id {point.id}; change either's seed"
        )


def joined(
    points: dict[str, Point], parameters: Parameters, series: str, figures: Iterable[str]
) -> Point:
    """Return the point among ``points``, or a new one, as a member of a series and of figures.

    Of the figures it joins those that show it.
    """
    key = point_id(parameters)
    figures = [name for name in figures if FIGURES[name].shows(parameters)]
    known = points.get(key, Point(key, parameters, (), ()))
    return replace(
        known,
        series=tuple(dict.fromkeys((*known.series, series))),
        figures=tuple(dict.fromkeys((*known.figures, *figures))),
    )


def _figures(
    file: StudyFile, points: dict[str, Point], fed: Fed, source: str
) -> dict[str, tuple[str, ...]]:
    """Collect the points of each figure, and refuse a figure that misses its series."""
    for place, name in enumerate(file.figures or []):
        if name not in fed:
            allowed = "a figure that a series of the study feeds"
            raise InputError.of_value(source, f"figures[{place}]", name, allowed)
    figures = {}
    for name in FIGURES:
        if name not in fed:
            continue
        if file.figures is not None and name not in file.figures:
            allowed = "a figure that the study lists under figures"
            raise InputError.of_value(*fed[name], name, allowed)
        members = [point for point in points.values() if name in point.figures]
        _require_members(name, members, *fed[name])
        figures[name] = tuple(point.id for point in members)
    return figures


def _require_members(name: str, members: list[Point], source: str, path: str) -> None:
    """Refuse a figure whose points are not those that it shows, or do not vary its axes."""
    spec = FIGURES[name]
    if not members:
        wanted = ", ".join(f"{key} {_written(value)}" for key, value in spec.where.items())
        raise InputError.of_value(source, path, name, f"series with a point at {wanted}")
    for axis in spec.axes:
        values = {getattr(point.parameters, axis) for point in members}
        if len(values) < 2:
            got = f"{name} with {axis} = {_written(values.pop())} alone"
            axes = ", ".join(spec.axes)
            allowed = f"series that feed {name} and together vary {axes}"
            raise InputError.of_value(source, path, got, allowed)


def _written(value: Any) -> str:
    """Write a value of a parameter, or the values that it may have."""
    if isinstance(value, tuple):
        return " or ".join(_written(one) for one in value)
    return value if isinstance(value, str) else f"{value:g}"
