"""Convert the plots of a study file to figure entries like those of the catalogue."""

from collections.abc import Iterable, Sequence
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
from sim.study.figure_points import require_distinct_positions
from sim.study.figure_spec import FigureSpec
from sim.study.file import StudyFile
from sim.study.model import Point, Study
from sim.study.plot_checks import (
    require_distinct_map_points,
    require_parameters,
    varying_parameters,
)
from sim.study.plot_file import AXES, OBSERVABLE, REGIME, PlotFile
from sim.study.plot_kinds import plugin_code
from sim.study.plot_words import caption_lead, default_title
from sim.study.plottable import Observable, PlotErrorMaker, every_name, find_observable


def plot_specs(
    file: StudyFile, study: Study, source: str, other_names: Iterable[str] = ()
) -> dict[str, FigureSpec]:
    """Return a map from the name of each plot of a study file to its figure entry.

    Parameters
    ----------
    file : StudyFile
        The file.
    study : Study
        The study, with points and series.
    source : str
        The file's name, for messages.
    other_names : iterable of str
        Names of other plots of the study.

    Raises
    ------
    InputError
        For clashing names; unknown series, parameters or observables; parameters that do not
        vary; and points that a plot could not tell apart.
    """
    specs: dict[str, FigureSpec] = {}
    for number, plot in enumerate(file.plots or []):

        def plot_error(key: str, value: Any, allowed: str, number: int = number) -> InputError:
            return InputError.of_value(source, f"plots[{number}].{key}", value, allowed)

        # Some file systems do not tell capitals from small letters.
        if plot.name.lower() in FIGURES:
            raise plot_error("name", plot.name, "a name that no figure of the catalogue has")
        if plot.name.lower() in map(str.lower, (*specs, *other_names)):
            raise plot_error("name", plot.name, "a name that no other plot has, capitals or not")
        specs[plot.name] = _plot_spec(plot, study, plot_error, source, f"plots[{number}]")
    return specs


def points_of_plot(spec: FigureSpec, points: Iterable[Point]) -> tuple[str, ...]:
    """Return the ids of the points of a study that a plot shows."""
    return tuple(
        point.id for point in points if spec.is_fed_by(point.parameters.system, point.series)
    )


def _plot_spec(
    plot: PlotFile, study: Study, plot_error: PlotErrorMaker, source: str, path: str
) -> FigureSpec:
    """Return the figure entry of a plot."""
    names = _series_names(plot, study, plot_error)
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
    require_distinct_positions(spec, points, source, path)
    return spec


def _series_names(plot: PlotFile, study: Study, plot_error: PlotErrorMaker) -> Sequence[str]:
    for number, name in enumerate(plot.series or []):
        if name not in study.series:
            raise plot_error(f"series[{number}]", name, "one of " + ", ".join(study.series))
    return plot.series or list(study.series)


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
