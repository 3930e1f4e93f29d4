"""What plots can show: their kinds, the call that declares one, observables and parameters by name.

Those that ship stand in `sim.figures.kinds`. Nothing imports it by a statement.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import wraps
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

from sim.base.additions import AdditionError, add, additions, attribute_errors_to, shipped
from sim.base.errors import Allowed, in_short, printable
from sim.base.messages import MOST_NAMES, did_you_mean, near, one_of
from sim.base.plugins import require_function, require_one_of, with_declared_types
from sim.parameters import SYSTEMS
from sim.parameters.variables import Variable, observable_variables, plotted_name, variables_of

if TYPE_CHECKING:
    import pandas as pd

#: Kind of the additions that are kinds of plot, and package of those that ship.
PLOT, SHIPPED = "plot", "sim.figures.kinds"

#: Value of the key of the observable that is none: a map of regimes.
REGIME = "regime"

#: Function of the data of a figure, `sim.figures.data.FigureData`.
OfData = Callable[[Any], Any]

#: What functions of a plug-in return: a method or attribute of it, and in words.
_RETURNED = {
    "draw": ("savefig", "a figure of matplotlib"),
    "table": ("to_csv", "a pandas.DataFrame"),
    "select": ("rows", "the data of a figure"),
}


class Shown(IntEnum):
    """What is shown of the particles of a point, the later the more of them is kept."""

    NOTHING = 0
    STATE = 1
    PATH = 2


@dataclass(frozen=True)
class Keys:
    """The keys that a kind of plot takes, and what they name.

    ``axes`` are keys of the parameters on its axes, ``observable`` is that of the observable (empty
    for a kind of papers' figures alone), ``usual`` what is shown where this is omitted, and
    ``shows`` a function: system → observables that can be shown, by name. ``second`` is the key of
    an observable that the first is shown against; ``several`` that of a list of at most ``most``
    parameters, each on an axis (all that vary, where it is omitted). ``log`` are axes that can be
    logarithmic, ``others`` further keys. ``of_papers`` are what papers' figures take besides, and
    ``systems`` those of which papers can have figures, empty for all. ``what`` and ``over`` say
    what titles make of the name of the observable, and of the axes. ``particles`` is what the
    dataset keeps of them for it. It is ``animated`` or reads run files, ``from_runs``.
    """

    axes: tuple[Literal["x", "y"], ...] = ()
    observable: Literal["", "x", "y", "colour"] = ""
    usual: str = "velocity"
    shows: Callable[[str], Mapping[str, Any]] = lambda system: {}
    second: Literal["", "x", "y"] = ""
    several: Literal["", "parameters"] = ""
    most: int = 12
    log: tuple[Literal["x", "y", "colour"], ...] = ()
    others: tuple[Literal["curves", "colour", "panels", "between", "beside", "fit"], ...] = ()
    of_papers: str = ""
    systems: tuple[str, ...] = ()
    what: str = "{}"
    over: str = "against {}"
    particles: Shown = Shown.NOTHING
    animated: bool = False
    from_runs: bool = False

    @property
    def every(self) -> tuple[str, ...]:
        """All keys of a study's plot of the kind, besides those of all kinds."""
        named = *self.axes, self.several, self.observable, self.second, *self.others
        return tuple(dict.fromkeys(filter(None, named)))

    @property
    def is_map(self) -> bool:
        """Whether both axes are parameters, so that each point has a place of its own."""
        return len(self.axes) == 2


#: Names of the functions of a kind.
ROLES = "draw", "table", "notes", "select"


@dataclass(frozen=True)
class PlotKind:
    """A kind of plot.

    ``drawing`` names a module, or an object in one, that has its functions; it is imported to draw.
    They are ``draw`` (the picture), ``table`` (the data behind it, with units in the headings),
    ``notes`` (the sentences of the caption) and ``select`` (the data with the points to draw only).
    ``own`` are those of a plug-in, in their place.
    """

    keys: Keys
    drawing: str = ""
    own: Mapping[str, OfData] = field(default_factory=dict, repr=False)


def plot_kind(
    name: str,
    *,
    like: str = "",
    keys: Keys | None = None,
    table: "Callable[[Any], pd.DataFrame] | None" = None,
    notes: Callable[[Any], Sequence[str]] | None = None,
    select: OfData | None = None,
) -> Callable[[OfData], OfData]:
    """Declare a kind of plot; the decorated function draws it.

    The function gets the data of a figure: its ``spec``, a table ``rows`` of its points, and the
    ``results`` of the study. It returns a matplotlib figure.

    Parameters
    ----------
    name : str
        The ``kind`` that study files give.
    like : str
        Kind of Talus whose keys it takes, where it has no ``keys`` of its own; the same checks
        apply.
    keys : Keys, optional
        The keys that it takes.
    table, notes : callable, optional
        Functions that return the data behind the picture, and the sentences of the caption. By
        default, those of ``like``.
    select : callable, optional
        Function that returns the data with the points to draw only.
    """
    if keys is None:
        require_one_of(f"plot {name}: like", like, study_kinds())
        base = kinds()[like]
    elif like or not isinstance(keys, Keys):
        got = in_short(keys)
        raise AdditionError(f"plot {name}: keys is of type Keys, without like: got {got}")
    else:
        base = PlotKind(with_declared_types(f"plot {name}: keys", keys))
    # Nothing draws data beside the plot of a plug-in, or fits a law to it.
    others = tuple(key for key in base.keys.others if key not in ("beside", "fit"))
    given: dict[str, OfData | None] = {"table": table, "notes": notes, "select": select}
    own = {role: function for role, function in given.items() if function is not None}
    for role, function in own.items():
        require_function(f"plot {name}: {role}", function, takes=1)
    if notes:
        own["notes"] = lambda data: [printable(note) for note in notes(data)]

    def register(draw: OfData) -> OfData:
        require_function(f"plot {name}", draw, takes=1)
        every = (own | {"draw": draw}).items()
        functions = {role: _attributed(name, role, function) for role, function in every}
        add(PLOT, name, PlotKind(replace(base.keys, others=others), base.drawing, functions))
        return draw

    return register


def _attributed(name: str, role: str, function: OfData) -> OfData:
    """Return a function whose errors name the plug-in of a kind, and its place there."""
    method, what = _RETURNED.get(role, ("", ""))

    @wraps(function)
    def call(data: Any) -> Any:
        with attribute_errors_to(PLOT, name, f" {data.spec.name}"):
            answer = function(data)
            if method and not hasattr(answer, method):
                raise TypeError(f"{role} returns {what}: got {in_short(answer)}")
            return answer

    return call


def kinds() -> Mapping[str, PlotKind]:
    """Return all kinds of plot by name: those that ship, then those of plug-ins."""
    import_module(SHIPPED)
    own = {name: addition.value for name, addition in additions(PLOT).items()}
    return dict(sorted(shipped(PLOT).items())) | own


def study_kinds(*, own: bool = False) -> list[str]:
    """Return the names of the kinds of studies' plots, with ``own`` those of plug-ins, too."""
    every, ours = kinds(), shipped(PLOT)
    return [name for name in every if every[name].keys.observable and (own or name in ours)]


#: Greatest depth n whose pictures show a portion of the cell: the half near the viewer.
LARGEST_PORTION = 10

#: Profiles of a chute flow end where this share of the spheres' volume is below.
SHARE = 0.995

#: Flows slower than this (√(gσ)) that are not at rest are said to creep.
CREEP = 0.1

#: Greatest height of the beads in an animation (⟨d⟩); few beads of a gas fly higher.
TALLEST = 24.0


@dataclass(frozen=True)
class Observable:
    """An observable of the points of one system, by the name that study files call it.

    ``source`` is the variable of the dataset or the run file that it is from, ``unit`` as UDUNITS
    reads it, ``is_mean`` whether it is the mean of a profile over the particles, ``asked_by`` the
    parameter that a point needs for it to be kept, if any.
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
    rows = variables_of("profile", system=system).values()
    return _by_name(row for row in rows if system in row.in_datasets and not row.of)


def series(system: str) -> dict[str, Observable]:
    """Return the time series of run files."""
    return _by_name(variables_of("series", system=system).values())


def _by_name(rows: Iterable[Variable]) -> dict[str, Observable]:
    named = {plotted_name(row.name): row for row in rows}
    return {name: _observable(name, row) for name, row in named.items()}


def _observable(name: str, row: Variable) -> Observable:
    return Observable(name, row.name, row.unit, row.meaning, asked_by=row.asked_by)


def shown_by() -> dict[str, dict[str, Mapping[str, Observable]]]:
    """Return the observables that each kind of a study's plots can show, by kind and system."""
    shows = {kind: kinds()[kind].keys.shows for kind in study_kinds()}
    return {kind: {system: show(system) for system in SYSTEMS} for kind, show in shows.items()}


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
        is_switch = all(isinstance(getattr(one.parameters, option, False), bool) for one in points)
        value = ": true" if is_switch else ""
        raise error(f"points with {option}{value}, as runs record it only then")
    if observable.source in variables_of("profile") and not all(one.profiles for one in points):
        raise error("points of series without profiles: false, as the dataset has none of theirs")


#: Function: key of a plot, its value, allowed values → error to raise.
ErrorMaker = Callable[[str, Any, str | Allowed], Exception]


def find_observable(kind: str, key: str, name: str, system: str, error: ErrorMaker) -> Observable:
    """Return the observable that a key of a plot names.

    Raises what ``error`` makes for a name that it cannot show.
    """
    shows = kinds()[kind].keys.shows
    observables = shows(system)
    if name in observables:
        return observables[name]
    if name in SYSTEMS[system].model_fields:
        raise error(key, name, f"an observable of the {system}; {name} is a parameter")
    for other in SYSTEMS:
        if name in shows(other):
            allowed = f"an observable of the {system}; {name} is one of the {other}"
            raise error(key, name, allowed)
    for other, shown in shown_by().items():
        if name in shown[system]:
            allowed = f"an observable of {kind}; {name} is shown by kind: {other}"
            raise error(key, name, allowed)
    raise error(key, name, one_of(name, observables))


def require_parameter(
    key: str,
    name: str,
    system: str,
    observables: Collection[str],
    plot_error: ErrorMaker,
    varied: Collection[str] = (),
) -> None:
    """Raise an error unless a name is a parameter of the system, and on an axis a number.

    ``observables`` are allowed in its place; they and the ``varied`` parameters only appear in the
    message.
    """
    fields = SYSTEMS[system].model_fields
    if name not in fields or name == "system":
        for other, model in SYSTEMS.items():
            if name in model.model_fields.keys() - {"system"}:
                allowed = f"a parameter of the {system}; this is one of the {other}"
                raise plot_error(key, name, allowed)
        names, most = [field for field in fields if field != "system"], MOST_NAMES // 2
        allowed = f"a parameter of the {system} that the points vary: "
        allowed += near(name, varied or names, most)
        if observables:
            allowed += f"; or an observable: {near(name, observables, most)}"
        question = did_you_mean(name, [*names, *observables])
        raise plot_error(key, name, Allowed(question, allowed))
    if key in ("x", "y") and fields[name].annotation not in (int, float):
        raise plot_error(key, name, "a parameter that is a number; curves and panels take any")
