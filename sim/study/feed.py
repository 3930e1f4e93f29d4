"""Last step of a study: feed its points to figures of the catalogue and to its own plots."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.base.messages import one_of
from sim.parameters import NUMERICAL, SYSTEMS, Parameters, canonical_number, field_info, roles
from sim.study.catalogue import FIGURES
from sim.study.figure_spec import FigureSpec, written
from sim.study.file import StudyFile
from sim.study.model import Point, Study
from sim.study.plot_contents import (
    PlotContents,
    caption_lead,
    default_title,
    same_plane,
    varying_parameters,
)
from sim.study.plot_kinds import plugin_code


def feed(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the figures that its points feed, and with the plots of its files.

    Raises
    ------
    InputError
        If a figure is listed but not fed, or fed but not listed. Also if it shows none of its
        points, if these do not vary its axes, or if two would share one position on a curve. For
        plots with clashing names, unknown series, parameters or observables, and parameters that
        do not vary.
    """
    entries, data = _figures(study, files), []
    for number, (path, file) in enumerate(files):
        # A part knows its own series alone.
        series = [entry.name for _, entry in file.entries] if number else list(study.series)
        for index, plot in enumerate(file.plots or []):
            names = plot.series or series
            points = [point for point in study.points.values() if set(point.series) & set(names)]
            contents = PlotContents(plot, points, str(path), f"plots[{index}]")
            _require_known_names(contents, series, entries)
            entries[plot.name] = plot_entry(contents, names)
            data += [path.parent / one.file for one in plot.beside or () if one.file]
    return replace(study, entries=entries, data=tuple(dict.fromkeys(data)))


def _figures(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> dict[str, FigureSpec]:
    feeds: dict[str, tuple[str, str]] = {}
    for path, file in files:
        for key, entry in file.entries:
            for index, name in enumerate(entry.figures):
                feeds.setdefault(name, (str(path), f"{key}.figures[{index}]"))
    path, file = files[0]
    for index, name in enumerate(file.figures or []):
        if name not in feeds:
            allowed = "a figure that a series of the study feeds"
            raise InputError.of_value(path, f"figures[{index}]", name, allowed)
    figures = {name: spec for name, spec in FIGURES.items() if name in feeds}
    for name, spec in figures.items():
        if file.figures is not None and name not in file.figures:
            allowed = "a figure that the study lists under figures"
            raise InputError.of_value(*feeds[name], name, allowed)
        points = [point for point in study.points.values() if name in point.figures]
        _require_points_vary(spec, points, *feeds[name])
        _require_distinct_positions(spec, points, *feeds[name])
    return figures


def _require_known_names(
    contents: PlotContents, series: Sequence[str], entries: Iterable[str]
) -> None:
    name = contents.plot.name
    # Some file systems do not tell capitals from small letters.
    if name.lower() in FIGURES:
        raise contents.error("name", name, "a name that no figure of the catalogue has")
    if name.lower() in map(str.lower, entries):
        raise contents.error("name", name, "a name that no other plot has, capitals or not")
    for number, one in enumerate(contents.plot.series or []):
        if one not in series:
            raise contents.error(f"series[{number}]", one, one_of(one, series))


def plot_entry(contents: PlotContents, series: Sequence[str]) -> FigureSpec:
    """Return the figure entry of a plot of some series; raise ``InputError`` as `feed` does."""
    contents.require_drawable()
    follows = {
        "title": contents.plot.title or default_title(contents),
        "lead": caption_lead(contents),
        "named": _caption_parameters(contents.system, contents.parameters),
        "series": list(series),
        "log": contents.log,
        "foreign": contents.beside,
        "scattered": contents.suits_scatter,
        "plugin": plugin_code(contents.plot.kind),
    }
    spec = contents.spec.model_copy(update=follows)
    _require_distinct_positions(spec, contents.points, contents.source, contents.place)
    return spec


def _require_points_vary(
    spec: FigureSpec, figure_points: Sequence[Point], source: str, path: str
) -> None:
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


def _require_distinct_positions(
    spec: FigureSpec, figure_points: Sequence[Point], source: str, path: str
) -> None:
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
    names = dict.fromkeys((*spec.axes, *spec.groups))
    return ", ".join(f"{name} = {written(getattr(parameters, name))}" for name in names)


def _differences(first: Parameters, second: Parameters) -> str:
    names = type(first).model_fields
    pairs = {name: (getattr(first, name), getattr(second, name)) for name in names}
    return ", ".join(
        f"{name} ({written(value)}, {written(other_value)})"
        for name, (value, other_value) in pairs.items()
        if value != other_value
    )


def _series_note(first: Point, second: Point) -> str:
    names = first.series[0], second.series[0]
    return f" (series {names[0]} and {names[1]})" if names[0] != names[1] else ""


#: Parameters that captions give elsewhere or not at all.
_NOT_IN_CAPTION = {"system", "protocol", "start_from"}


def _caption_parameters(system: str, points: Sequence[Parameters]) -> list[str]:
    """Return the parameters in a caption: part of ids, varied, or different from the default."""
    model = SYSTEMS[system]
    rows, always = field_info(model), {*roles.id_parts(model), "transient", "average"}
    unusual = {
        name
        for name, row in rows.items()
        if name not in NUMERICAL
        and name not in _NOT_IN_CAPTION
        and row.default is not None
        and any(getattr(point, name) != canonical_number(row.default) for point in points)
    }
    chosen = always | unusual | set(varying_parameters(points))
    if all(map(same_plane, points)):
        # The plane has the friction of the particles.
        chosen -= {"friction_plane"}
    return [name for name in rows if name in chosen and name not in _NOT_IN_CAPTION]
