"""What plots can show: observables and parameters by their names, with units and meanings."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sim.base.errors import Allowed
from sim.base.messages import MOST_NAMES, did_you_mean, near, one_of
from sim.parameters import SYSTEMS
from sim.parameters.variables import Variable, observable_variables, plotted_name, variables_of
from sim.study.plot_kinds import find_kind, study_kinds


@dataclass(frozen=True)
class Observable:
    """An observable of the points of one system.

    Attributes
    ----------
    name : str
        What study files call it.
    source : str
        Variable of the dataset, or of the run file, that it is from.
    unit, meaning : str
        Unit as UDUNITS reads it, and what it is.
    is_mean : bool
        Whether it is the mean of a profile over the particles.
    asked_by : str
        Parameter that a point needs for it to be kept, if any.
    """

    name: str
    source: str
    unit: str
    meaning: str
    is_mean: bool = False
    asked_by: str = ""


def numbers(system: str) -> dict[str, Observable]:
    """Return the numbers per replicate: scalars, observables, means of profiles."""
    rows = variables_of("scalar", system=system) | observable_variables(system)
    scalars = {name: _observable(name, row) for name, row in rows.items() if row.unit}
    means = {
        name: replace(one, meaning=f"{one.meaning}, mean of all particles", is_mean=True)
        for name, one in profiles(system).items()
        if name not in scalars
    }
    return scalars | means


def profiles(system: str) -> dict[str, Observable]:
    """Return the profiles over the height that datasets keep, averages of the window."""
    return {
        (name := plotted_name(source)): _observable(name, row)
        for source, row in variables_of("profile", system=system).items()
        if system in row.in_datasets and not row.of
    }


def series(system: str) -> dict[str, Observable]:
    """Return the time series of run files."""
    rows = variables_of("series", system=system)
    return {(name := plotted_name(source)): _observable(name, row) for source, row in rows.items()}


def _observable(name: str, row: Variable) -> Observable:
    return Observable(name, row.name, row.unit, row.meaning, asked_by=row.asked_by)


def shown_by() -> dict[str, dict[str, Mapping[str, Observable]]]:
    """Return the observables that each kind of a study's plots can show, by kind and system."""
    return {
        kind: {system: find_kind(kind).keys.shows(system) for system in SYSTEMS}
        for kind in study_kinds()
    }


def every_name() -> list[str]:
    """Return the names of the observables of all kinds of plot and systems."""
    shown = (names for systems in shown_by().values() for names in systems.values())
    return list(dict.fromkeys(name for names in shown for name in names))


def require_stored(
    observable: Observable, points: Sequence[Any], error: Callable[[str], Exception]
) -> None:
    """Raise what ``error`` makes of the allowed points, unless all will have the observable.

    Runs record some observables only where a point asks for them, and a series may leave profiles
    out of the dataset.
    """
    option = observable.asked_by
    if option and not all(getattr(point.parameters, option, False) for point in points):
        raise error(f"points with {option}: true, as runs record it only then")
    if observable.source in variables_of("profile") and not all(one.profiles for one in points):
        raise error("points of series without profiles: false, as the dataset has none of theirs")


#: Function: key of a plot, its value, allowed values → error to raise.
PlotErrorMaker = Callable[[str, Any, str | Allowed], Exception]


def find_observable(
    kind: str, key: str, name: str, system: str, plot_error: PlotErrorMaker
) -> Observable:
    """Return the observable that a key of a plot names.

    Raises what ``plot_error`` makes for a name that it cannot show.
    """
    shows = find_kind(kind).keys.shows
    observables = shows(system)
    if name in observables:
        return observables[name]
    for other in SYSTEMS:
        if name in shows(other):
            raise plot_error(
                key, name, f"an observable of the {system}; {name} is one of the {other}"
            )
    for other, shown in shown_by().items():
        if name in shown[system]:
            raise plot_error(
                key, name, f"an observable of {kind}; {name} is shown by kind: {other}"
            )
    raise plot_error(key, name, one_of(name, observables))


def require_parameter(
    key: str,
    name: str,
    system: str,
    observables: Collection[str],
    plot_error: PlotErrorMaker,
    varied: Collection[str] = (),
) -> None:
    """Raise an error unless a name is a parameter of the system, and on an axis a number.

    ``observables`` are allowed in its place; they and the ``varied`` parameters only appear in the
    message.
    """
    fields = SYSTEMS[system].model_fields
    if name not in fields or name == "system":
        others = [other for other, model in SYSTEMS.items() if name in model.model_fields]
        if name != "system" and others:
            raise plot_error(
                key, name, f"a parameter of the {system}; this is one of the {others[0]}"
            )
        names, most = [field for field in fields if field != "system"], MOST_NAMES // 2
        allowed = f"a parameter of the {system} that the points vary: "
        allowed += near(name, varied or names, most)
        if observables:
            allowed += f"; or an observable: {near(name, observables, most)}"
        question = did_you_mean(name, [*names, *observables])
        raise plot_error(key, name, Allowed(question, allowed))
    if key in ("x", "y") and fields[name].annotation not in (int, float):
        raise plot_error(key, name, "a parameter that is a number; curves and panels take any")
