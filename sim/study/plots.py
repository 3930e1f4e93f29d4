"""From the plots of a study file to entries of the same kind as the catalogue's."""

from collections.abc import Iterable, Sequence
from typing import Any

from sim.base.errors import InputError
from sim.base.messages import did_you_mean
from sim.parameters import (
    NUMERICAL,
    SYSTEMS,
    Parameters,
    canonical_number,
    field_info,
    roles,
)
from sim.study.catalogue import FigureSpec
from sim.study.figure_points import require_places
from sim.study.file import StudyFile
from sim.study.model import Point, Study
from sim.study.plot_checks import Refused, require_nothing_else, require_parameters, varying_of
from sim.study.plot_file import AXES, OBSERVABLE, REGIME, PlotFile
from sim.study.plot_kinds import code_of
from sim.study.plot_words import lead_of, title_of
from sim.study.plottable import SHOWN_BY, Observable, every_name


def plots_of(
    file: StudyFile, study: Study, source: str, taken: Iterable[str] = ()
) -> dict[str, FigureSpec]:
    """Return the plots of a study file as entries of figures, by name.

    Parameters
    ----------
    file : StudyFile
        The file.
    study : Study
        Its points and series.
    source : str
        The file's name, for messages.
    taken : iterable of str
        Names that other plots of the study have.

    Raises
    ------
    InputError
        For names that clash, unknown series, parameters or observables, parameters that do not
        vary, and points that a plot could not tell apart.
    """
    found: dict[str, FigureSpec] = {}
    for number, one in enumerate(file.plots or []):

        def refused(key: str, value: Any, allowed: str, number: int = number) -> InputError:
            return InputError.of_value(source, f"plots[{number}].{key}", value, allowed)

        # Some file systems do not tell capitals from small letters.
        if one.name.lower() in map(str.lower, (*found, *taken)):
            raise refused("name", one.name, "a name that no other plot has, capitals or not")
        found[one.name] = _entry(one, study, refused, source, f"plots[{number}]")
    return found


def points_shown(spec: FigureSpec, points: Iterable[Point]) -> tuple[str, ...]:
    """Return the ids of the points of a study that a plot shows."""
    return tuple(
        point.id for point in points if spec.is_fed_by(point.parameters.system, point.series)
    )


def _entry(one: PlotFile, study: Study, refused: Refused, source: str, path: str) -> FigureSpec:
    """Return a plot as an entry like those of the catalogue."""
    names = _series(one, study, refused)
    points = [point for point in study.points.values() if set(point.series) & set(names)]
    system = _system(one, points, refused)
    points = [point for point in points if point.parameters.system == system]
    key, _ = OBSERVABLE[one.like]
    is_map = one.like == "map" and one.observable == REGIME
    observable = None if is_map else _observable(one, key, one.observable, system, points, refused)
    second = _second(one, system, points, refused)
    axes = () if second else one.on_axes
    curves, panels = tuple(one.curves or ()), one.panels or ""
    require_parameters(one, axes, system, points, refused)
    spec = FigureSpec(
        name=one.name,
        kind=f"plot_{one.kind}",
        paper="",
        system=system,
        title=one.title or title_of(one, observable, second),
        axes=axes,
        curves=curves + ((panels,) if panels else ()),
        lead=lead_of(one, observable, second, system),
        named=_named(system, [point.parameters for point in points]),
        series=tuple(names),
        options={
            "show": one.observable,
            "second": second.name if second else "",
            "between": tuple(one.between or ()),
            "beside": tuple(
                (each.label, tuple(map(tuple, each.points)), each.line) for each in one.beside or ()
            ),
            "panels": panels,
            "curves": curves,
            "units": one.units,
            "log": tuple(one.log),
        }
        | code_of(one.kind),
    )
    if one.like == "map":
        require_nothing_else(spec, points, refused)
    require_places(spec, points, source, path)
    return spec


def _series(one: PlotFile, study: Study, refused: Refused) -> Sequence[str]:
    for number, name in enumerate(one.series or []):
        if name not in study.series:
            raise refused(f"series[{number}]", name, "one of " + ", ".join(study.series))
    return one.series or list(study.series)


def _system(one: PlotFile, points: Sequence[Point], refused: Refused) -> str:
    """Return the system of a plot: what it says, or that of all its points."""
    there = list(dict.fromkeys(point.parameters.system for point in points))
    if one.system is None and len(there) > 1:
        raise refused("system", None, "one of " + ", ".join(there) + ", as the series have several")
    system = one.system or there[0]
    if system not in there:
        raise refused("system", system, f"a system of its series: {', '.join(there)}")
    return system


def _second(
    one: PlotFile, system: str, points: Sequence[Point], refused: Refused
) -> Observable | None:
    """Return the observable on the other axis too; nothing where a parameter is there, or may be.

    What is neither is refused with the parameters.
    """
    name = getattr(one, one.second) if one.second else None
    if name is None or (one.second in AXES[one.like] and name not in every_name()):
        return None
    if name == one.observable:
        key, _ = OBSERVABLE[one.like]
        raise refused(one.second, name, f"an observable other than {key}")
    return _observable(one, one.second, name, system, points, refused)


def _observable(
    one: PlotFile, key: str, name: str, system: str, points: Sequence[Point], refused: Refused
) -> Observable:
    """Return an observable that a plot shows, which its key names."""
    known = SHOWN_BY[one.like](system)
    found = known.get(name)
    if found is None:
        raise refused(key, name, _instead(one, name, system, list(known)))
    if found.asked_by and not all(
        getattr(point.parameters, found.asked_by, False) for point in points
    ):
        allowed = f"points with {found.asked_by}: true, without which it is not kept"
        raise refused(key, name, allowed)
    return found


def _instead(one: PlotFile, name: str, system: str, known: list[str]) -> str:
    """Say what may be meant by an observable that a kind of plot does not know."""
    for other in SYSTEMS:
        if other != system and name in SHOWN_BY[one.like](other):
            return f"an observable of the {system}; {name} is one of the {other}"
    for kind, shown in SHOWN_BY.items():
        if name in shown(system):
            return f"an observable of {one.kind}; {name} is shown by kind: {kind}"
    return did_you_mean(name, known) + "one of " + ", ".join(known)


#: Parameters that captions tell elsewhere, or not at all.
_APART = {"system", "protocol", "start_from"}


def _named(system: str, points: Sequence[Parameters]) -> tuple[str, ...]:
    """Return the parameters that a caption gives: those that name points, vary or are not usual."""
    model = SYSTEMS[system]
    rows, always = field_info(model), {*roles.id_parts(model), "transient", "average"}
    unusual = {
        name
        for name, row in rows.items()
        if name not in NUMERICAL
        and name not in _APART
        and row.default is not None
        and any(getattr(one, name) != canonical_number(row.default) for one in points)
    }
    chosen = always | unusual | set(varying_of(points))
    if all(getattr(one, "friction_plane", 0) == getattr(one, "friction", 0) for one in points):
        # A plane as rough as the particles.
        chosen -= {"friction_plane"}
    return tuple(name for name in rows if name in chosen and name not in _APART)
