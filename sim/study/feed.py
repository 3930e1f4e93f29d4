"""Last step of a study: feed its points to figures of the catalogue and to its own plots."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.parameters import (
    NUMERICAL,
    SYSTEMS,
    Parameters,
    canonical_number,
    field_info,
    roles,
)
from sim.study.catalogue import FIGURES
from sim.study.figure_checks import (
    require_distinct_map_points,
    require_distinct_positions,
    require_parameters,
    require_points_vary,
    varying_parameters,
)
from sim.study.figure_spec import FigureSpec
from sim.study.file import StudyFile
from sim.study.model import Point, Study
from sim.study.plot_file import AXES, OBSERVABLE, REGIME, PlotFile
from sim.study.plot_kinds import plugin_code
from sim.study.plot_words import caption_lead, default_title
from sim.study.plottable import Observable, PlotErrorMaker, every_name, find_observable


def feed(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the figures that its points feed, and with the plots of its files.

    Raises
    ------
    InputError
        If a figure is listed but not fed, or fed but not listed. Also if it shows none of its
        points, if these do not vary its axes, or if two would share one position on a curve. For
        a plot that has the name of another, see `_plot_spec` for its other mistakes.
    """
    entries = _figures(study, files)
    for number, (path, file) in enumerate(files):
        # A part knows its own series alone.
        series = [entry.name for _, entry in file.entries] if number else list(study.series)
        for index, plot in enumerate(file.plots or []):
            place = f"plots[{index}]"
            _require_new_name(plot.name, entries, str(path), f"{place}.name")
            entries[plot.name] = _plot_spec(plot, study, series, str(path), place)
    return replace(study, entries=entries)


def _figures(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> dict[str, FigureSpec]:
    """Return the entries of the catalogue that the series of a study feed."""
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
        require_points_vary(spec, points, *feeds[name])
        require_distinct_positions(spec, points, *feeds[name])
    return figures


def _require_new_name(name: str, entries: Iterable[str], source: str, key: str) -> None:
    # Some file systems do not tell capitals from small letters.
    if name.lower() in FIGURES:
        allowed = "a name that no figure of the catalogue has"
        raise InputError.of_value(source, key, name, allowed)
    if name.lower() in map(str.lower, entries):
        allowed = "a name that no other plot has, capitals or not"
        raise InputError.of_value(source, key, name, allowed)


def _plot_spec(
    plot: PlotFile, study: Study, series: Sequence[str], source: str, place: str
) -> FigureSpec:
    """Return the figure entry of a plot of a file with some series.

    Raises
    ------
    InputError
        For unknown series, parameters or observables; parameters that do not vary; and points
        that the plot could not tell apart.
    """

    def plot_error(key: str, value: Any, allowed: str) -> InputError:
        return InputError.of_value(source, f"{place}.{key}", value, allowed)

    for number, name in enumerate(plot.series or []):
        if name not in series:
            raise plot_error(f"series[{number}]", name, "one of " + ", ".join(series))
    names = plot.series or series
    points = [point for point in study.points.values() if set(point.series) & set(names)]
    system = _plot_system(plot, points, plot_error)
    points = [point for point in points if point.parameters.system == system]
    key, _ = OBSERVABLE[plot.base_kind]
    is_map = plot.base_kind == "map" and plot.observable == REGIME
    observable = (
        None if is_map else _observable(plot, key, plot.observable, system, points, plot_error)
    )
    second = _second_observable(plot, system, points, plot_error)
    axes = () if second else plot.axis_names
    curves, panels = tuple(plot.curves or ()), plot.panels or ""
    require_parameters(plot, axes, system, points, plot_error)
    spec = FigureSpec(
        name=plot.name,
        kind=f"plot_{plot.kind}",
        paper="",
        system=system,
        title=plot.title or default_title(plot, observable, second),
        axes=axes,
        curves=curves + ((panels,) if panels else ()),
        lead=caption_lead(plot, observable, second, system),
        named=_caption_parameters(system, [point.parameters for point in points]),
        series=tuple(names),
        options={
            "show": plot.observable,
            "second": second.name if second else "",
            "between": tuple(plot.between or ()),
            "beside": tuple(
                (data.label, tuple(map(tuple, data.points)), data.line)
                for data in plot.beside or ()
            ),
            "panels": panels,
            "curves": curves,
            "units": plot.units,
            "log": tuple(plot.log),
        }
        | plugin_code(plot.kind),
    )
    if plot.base_kind == "map":
        require_distinct_map_points(spec, points, plot_error)
    require_distinct_positions(spec, points, source, place)
    return spec


def _plot_system(plot: PlotFile, points: Sequence[Point], plot_error: PlotErrorMaker) -> str:
    """Return the system of a plot: the value of its key, or the only system of its points."""
    systems = list(dict.fromkeys(point.parameters.system for point in points))
    if plot.system is None and len(systems) > 1:
        raise plot_error(
            "system", None, "one of " + ", ".join(systems) + ", as the series have several"
        )
    system = plot.system or systems[0]
    if system not in systems:
        raise plot_error("system", system, f"a system of its series: {', '.join(systems)}")
    return system


def _second_observable(
    plot: PlotFile, system: str, points: Sequence[Point], plot_error: PlotErrorMaker
) -> Observable | None:
    """Return the second observable; ``None`` if a parameter is on that axis, or may be.

    A name of neither kind is refused later, with the parameters.
    """
    name = getattr(plot, plot.second_key) if plot.second_key else None
    if name is None or (plot.second_key in AXES[plot.base_kind] and name not in every_name()):
        return None
    if name == plot.observable:
        key, _ = OBSERVABLE[plot.base_kind]
        raise plot_error(plot.second_key, name, f"an observable other than {key}")
    return _observable(plot, plot.second_key, name, system, points, plot_error)


def _observable(
    plot: PlotFile,
    key: str,
    name: str,
    system: str,
    points: Sequence[Point],
    plot_error: PlotErrorMaker,
) -> Observable:
    """Return the observable that a key of a plot names, if its points keep it."""
    observable = find_observable(plot.base_kind, key, name, system, plot_error)
    if observable.asked_by and not all(
        getattr(point.parameters, observable.asked_by, False) for point in points
    ):
        allowed = f"points with {observable.asked_by}: true, without which it is not kept"
        raise plot_error(key, name, allowed)
    return observable


#: Parameters that captions give elsewhere or not at all.
_NOT_IN_CAPTION = {"system", "protocol", "start_from"}


def _caption_parameters(system: str, points: Sequence[Parameters]) -> tuple[str, ...]:
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
    if all(
        getattr(point, "friction_plane", 0) == getattr(point, "friction", 0) for point in points
    ):
        # The plane has the friction of the particles.
        chosen -= {"friction_plane"}
    return tuple(name for name in rows if name in chosen and name not in _NOT_IN_CAPTION)
