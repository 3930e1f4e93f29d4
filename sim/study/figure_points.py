"""Which points of a study each figure takes, and what it asks of them."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from sim.base.errors import InputError
from sim.parameters import Parameters
from sim.study.catalogue import FIGURES, FigureSpec, Shown
from sim.study.catalogue.spec import written
from sim.study.file import StudyFile
from sim.study.model import Point, Study
from sim.study.plot_kinds import like
from sim.study.points import Fed


def points_of_figures(
    file: StudyFile, points: Iterable[Point], fed: Fed, source: str
) -> dict[str, tuple[str, ...]]:
    """Return the ids of the points of each figure that a study feeds.

    Raises
    ------
    InputError
        For a figure that is listed and not fed, or fed and not listed; for one whose points are not
        those that it shows, do not vary its axes, or would be drawn at one place of a curve.
    """
    for place, name in enumerate(file.figures or []):
        if name not in fed:
            allowed = "a figure that a series of the study feeds"
            raise InputError.of_value(source, f"figures[{place}]", name, allowed)
    points = list(points)
    figures = {}
    for name, spec in FIGURES.items():
        if name not in fed:
            continue
        if file.figures is not None and name not in file.figures:
            allowed = "a figure that the study lists under figures"
            raise InputError.of_value(*fed[name], name, allowed)
        members = [point for point in points if name in point.figures]
        _require_members(spec, members, *fed[name])
        require_places(spec, members, *fed[name])
        figures[name] = tuple(point.id for point in members)
    return figures


def particles_shown(study: Study) -> Callable[[str], Shown]:
    """Return what tells of a point's id what figures show of its particles."""
    shown = {key: particles_in(point.figures) for key, point in study.points.items()}
    # Which points of later rounds there are, and which figures they feed, is not known yet.
    usual = particles_in(name for boundary in study.boundaries for name in boundary.figures)
    return lambda point: max(usual, shown.get(point, usual))


def particles_in(figures: Iterable[str]) -> Shown:
    """Return what some figures show of the particles of their points."""
    return max((FIGURES[name].particles for name in figures), default=Shown.NOTHING)


def needs_run_file(study: Study) -> Callable[[str], bool]:
    """Return what tells of a point's id whether its page or a figure is drawn from its run file.

    Figures of time series are, of the study's own and of plug-ins' kinds.
    """
    specs = [
        spec
        for spec in study.entries.values()
        if like(spec.kind.removeprefix("plot_")) == "time_series"
    ]
    points = set(study.points) if study.pages else set()
    points.update(*(study.figures[spec.name] for spec in specs))
    of_rounds = any(one.name in spec.series for spec in specs for one in study.boundaries)
    return lambda point: point in points or (of_rounds and point not in study.points)


def left_out(study: Study) -> list[str]:
    """Say of each figure how many points of the series that feed it it leaves out, and why.

    Pictures of a single point are passed over: what they leave out goes without saying.
    """
    sentences = []
    for name in study.figures:
        gone = [point for point in study.points.values() if name in point.left_out]
        if gone and study.entries[name].axes:
            every = len(gone) + len(study.figures[name])
            points = f"{len(gone):,} of {every:,} point" + "s" * (every > 1)
            sentences.append(f"{name} leaves out {points}: it takes {_reasons(name, gone)}")
    return sentences


def _reasons(name: str, gone: Sequence[Point]) -> str:
    """Write the values that a figure takes of each parameter for which it leaves points out."""
    spec = FIGURES[name]
    return "; ".join(
        f"{key} {listed}"
        for key, listed in spec.taken.items()
        if any(not spec.takes(key, point.parameters) for point in gone)
    )


def _require_members(spec: FigureSpec, members: Sequence[Point], source: str, path: str) -> None:
    """Refuse a figure whose points are not those that it shows, or do not vary its axes."""
    if not members:
        wanted = ", ".join(f"{key} {listed}" for key, listed in spec.taken.items())
        raise InputError.of_value(source, path, spec.name, f"series with a point at {wanted}")
    for axis in spec.axes:
        values = {getattr(point.parameters, axis) for point in members}
        if len(values) < 2:
            got = f"{spec.name} with {axis} = {written(values.pop())} alone"
            allowed = f"series that feed {spec.name} and together vary {', '.join(spec.axes)}"
            if axis in spec.taken:
                allowed += f", of which it takes {axis} {spec.taken[axis]} alone"
            raise InputError.of_value(source, path, got, allowed)


def require_places(spec: FigureSpec, members: Sequence[Point], source: str, path: str) -> None:
    """Refuse two points that a figure would draw at one place and could not tell apart."""
    if not spec.draws_curves:
        return
    found: dict[tuple[Any, ...], Point] = {}
    for point in members:
        other = found.setdefault(spec.place(point.parameters), point)
        if other is not point:
            raise InputError(
                f"{source}: {path}: got {spec.name} with two points at "
                f"{_settings(spec, point.parameters)} that differ in "
                f"{_differences(other.parameters, point.parameters)}{_in_series(other, point)}, "
                "which it does not show; allowed: one point at each place of a curve, the other "
                "in a series that does not feed it"
            )


def _settings(spec: FigureSpec, parameters: Parameters) -> str:
    names = dict.fromkeys((*spec.axes, *spec.curves))
    return ", ".join(f"{name} = {written(getattr(parameters, name))}" for name in names)


def _differences(one: Parameters, other: Parameters) -> str:
    """Name the parameters in which two points differ, with both values."""
    pairs = {name: (getattr(one, name), getattr(other, name)) for name in type(one).model_fields}
    return ", ".join(
        f"{name} ({written(first)}, {written(second)})"
        for name, (first, second) in pairs.items()
        if first != second
    )


def _in_series(one: Point, other: Point) -> str:
    """Name the series of two points, where these are not the same."""
    names = one.series[0], other.series[0]
    return f" (series {names[0]} and {names[1]})" if names[0] != names[1] else ""
