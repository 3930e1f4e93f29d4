"""Points of each figure of a study, and the conditions that they must meet."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from sim.base.errors import InputError
from sim.parameters import Parameters
from sim.study.catalogue import FIGURES
from sim.study.figure_spec import FigureSpec, Shown, written
from sim.study.file import StudyFile
from sim.study.model import Point, Study
from sim.study.plot_kinds import base_kind
from sim.study.points import FigureFeeds


def points_of_figures(
    file: StudyFile, points: Iterable[Point], feeds: FigureFeeds, source: str
) -> dict[str, tuple[str, ...]]:
    """Return the ids of the points of each figure that a study feeds.

    Raises
    ------
    InputError
        If a figure is listed but not fed, or fed but not listed. Also if it shows none of its
        points, if these do not vary its axes, or if two would share one position on a curve.
    """
    for index, name in enumerate(file.figures or []):
        if name not in feeds:
            allowed = "a figure that a series of the study feeds"
            raise InputError.of_value(source, f"figures[{index}]", name, allowed)
    points = list(points)
    figures = {}
    for name, spec in FIGURES.items():
        if name not in feeds:
            continue
        if file.figures is not None and name not in file.figures:
            allowed = "a figure that the study lists under figures"
            raise InputError.of_value(*feeds[name], name, allowed)
        figure_points = [point for point in points if name in point.figures]
        _require_points_vary(spec, figure_points, *feeds[name])
        require_distinct_positions(spec, figure_points, *feeds[name])
        figures[name] = tuple(point.id for point in figure_points)
    return figures


def particle_needs(study: Study) -> Callable[[str], Shown]:
    """Return a function: point id → how much of its particles the figures need."""
    needs = {key: particles_needed(point.figures) for key, point in study.points.items()}
    # The points of later rounds, and the figures that each feeds, are not known yet.
    minimum = particles_needed(name for boundary in study.boundaries for name in boundary.figures)
    return lambda point: max(minimum, needs.get(point, minimum))


def particles_needed(figures: Iterable[str]) -> Shown:
    """Return how much of their points' particles some figures need."""
    return max((FIGURES[name].particles for name in figures), default=Shown.NOTHING)


def needs_run_file(study: Study) -> Callable[[str], bool]:
    """Return a predicate: does this point need its run file (for its page or a time-series figure)?

    Time-series figures are the study's own plots of that kind, or of a plug-in's kind based on it.
    """
    specs = [
        spec
        for spec in study.entries.values()
        if base_kind(spec.kind.removeprefix("plot_")) == "time_series"
    ]
    points = set(study.points) if study.pages else set()
    points.update(*(study.figures[spec.name] for spec in specs))
    has_later_points = any(
        boundary.name in spec.series for spec in specs for boundary in study.boundaries
    )
    return lambda point: point in points or (has_later_points and point not in study.points)


def omission_notes(study: Study) -> list[str]:
    """Return a sentence for each figure that omits points of its series: how many, and why.

    Pictures of a single point get none, since they omit all other points by definition.
    """
    sentences = []
    for name in study.figures:
        omitted_points = [point for point in study.points.values() if name in point.left_out]
        if omitted_points and study.entries[name].axes:
            total = len(omitted_points) + len(study.figures[name])
            points = f"{len(omitted_points):,} of {total:,} point" + "s" * (total > 1)
            sentences.append(
                f"{name} leaves out {points}: it takes {_accepted_values(name, omitted_points)}"
            )
    return sentences


def _accepted_values(name: str, omitted_points: Sequence[Point]) -> str:
    """Return text with the values that a figure takes, for each parameter that excludes a point."""
    spec = FIGURES[name]
    return "; ".join(
        f"{key} {values}"
        for key, values in spec.taken.items()
        if any(not spec.takes(key, point.parameters) for point in omitted_points)
    )


def _require_points_vary(
    spec: FigureSpec, figure_points: Sequence[Point], source: str, path: str
) -> None:
    """Raise ``InputError`` for a figure without points, or whose points do not vary its axes."""
    if not figure_points:
        conditions = ", ".join(f"{key} {values}" for key, values in spec.taken.items())
        raise InputError.of_value(source, path, spec.name, f"series with a point at {conditions}")
    for axis in spec.axes:
        values = {getattr(point.parameters, axis) for point in figure_points}
        if len(values) < 2:
            got = f"{spec.name} with {axis} = {written(values.pop())} alone"
            allowed = f"series that feed {spec.name} and together vary {', '.join(spec.axes)}"
            if axis in spec.taken:
                allowed += f", of which it takes {axis} {spec.taken[axis]} alone"
            raise InputError.of_value(source, path, got, allowed)


def require_distinct_positions(
    spec: FigureSpec, figure_points: Sequence[Point], source: str, path: str
) -> None:
    """Raise ``InputError`` if a figure would draw two points indistinguishably at one position."""
    if not spec.draws_curves:
        return
    points_by_position: dict[tuple[Any, ...], Point] = {}
    for point in figure_points:
        other = points_by_position.setdefault(spec.place(point.parameters), point)
        if other is not point:
            raise InputError(
                f"{source}: {path}: got {spec.name} with two points at "
                f"{_settings(spec, point.parameters)} that differ in "
                f"{_differences(other.parameters, point.parameters)}{_series_note(other, point)}, "
                "which it does not show; allowed: one point at each place of a curve, the other "
                "in a series that does not feed it"
            )


def _settings(spec: FigureSpec, parameters: Parameters) -> str:
    names = dict.fromkeys((*spec.axes, *spec.curves))
    return ", ".join(f"{name} = {written(getattr(parameters, name))}" for name in names)


def _differences(first: Parameters, second: Parameters) -> str:
    """Return text with the parameters in which two points differ, and both values of each."""
    names = type(first).model_fields
    pairs = {name: (getattr(first, name), getattr(second, name)) for name in names}
    return ", ".join(
        f"{name} ({written(value)}, {written(other_value)})"
        for name, (value, other_value) in pairs.items()
        if value != other_value
    )


def _series_note(first: Point, second: Point) -> str:
    """Return text with the series of two points, empty if it is the same."""
    names = first.series[0], second.series[0]
    return f" (series {names[0]} and {names[1]})" if names[0] != names[1] else ""
