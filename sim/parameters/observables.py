"""Observables: numbers per replicate that are computed from run files, and the calls that add them.

Those that ship are in `sim.measures`; plug-ins add more. What a plug-in's function returns is one,
too. Forms are what the physics of a system suggests for an observable between points.
"""

from collections.abc import Callable, Collection, Mapping
from importlib import import_module
from inspect import signature
from itertools import chain
from typing import Annotated, Any, TypeVar

from sim.base.additions import AdditionError, add, additions, attribute_errors_to, shipped
from sim.base.plugins import (
    Declared,
    Unit,
    Words,
    allowed,
    declared,
    require_function,
    require_one_of,
    takes,
)
from sim.parameters.laws import FUNCTION, FUNCTION_NAME, RNG, Function
from sim.parameters.points import SYSTEMS
from sim.parameters.variables import OBSERVABLE, Measuring, Observable, reserved_names, variable

_Measuring = TypeVar("_Measuring", bound=Measuring)

#: Names in a dataset that are neither observables nor parameters.
_OF_DATASETS = {"point", "replicate", "series", "figures", "caveat", "particles", "boundaries"}


def _systems() -> tuple[str, ...]:
    """Return the systems that observables may be of, also while a first function is declared."""
    return (*SYSTEMS, FUNCTION_NAME)


#: Systems, one at least.
Systems = Annotated[
    tuple[str, ...],
    allowed(
        f"one of {', '.join(SYSTEMS)}",
        lambda names: names and all(isinstance(one, str) and one in _systems() for one in names),
    ),
]


class _Observable(Declared):
    system: Systems
    unit: Unit
    meaning: Words


def observable(
    name: str, *, system: str | Collection[str], unit: str, meaning: str, asked_by: str = ""
) -> Callable[[_Measuring], _Measuring]:
    """Declare an observable: a number for each completed replicate of a run, kept in the dataset.

    The function below gets a mapping: time series (T,), profiles (H,) with their ``height`` (m),
    first and last state of the particles, scalars and parameters of one replicate, by their names
    in run files. It returns a number, not-a-number where there is none. A function below several
    declarations returns a mapping of their names to numbers; a name that is missing has none.

    Parameters
    ----------
    name : str
        What studies and datasets call it.
    system : str or collection of str
        ``chute``, ``belt`` or ``conveyor``, or several of them.
    unit : str
        As UDUNITS reads it; ``"1"`` for pure numbers.
    meaning : str
        What it is, for axes and captions.
    asked_by : str
        A parameter without which runs do not record what the function needs.
    """
    systems = (system,) if isinstance(system, str) else tuple(system)
    what = f"observable {name}"
    declared(_Observable, what, system=systems, unit=unit, meaning=meaning)
    if asked_by:
        fields = [field for one in systems for field in SYSTEMS[one].model_fields]
        require_one_of(f"{what}: asked_by", asked_by, fields)

    def register(measure: _Measuring) -> _Measuring:
        require_function(what, measure, takes=1)
        texts = {"name": name, "unit": unit, "meaning": meaning, "asked_by": asked_by}
        observed = Observable(variable(OBSERVABLE, " ".join(systems), **texts), measure)
        parameters = chain(*(model.model_fields for model in SYSTEMS.values()))
        add(OBSERVABLE, name, observed, {*reserved_names(), *_OF_DATASETS, *parameters})
        return measure

    return register


def declare_observables(
    measure: Measuring, rows: Mapping[str, tuple[str, str]], **options: Any
) -> None:
    """Declare a function as the measure of several observables: name -> unit and meaning.

    ``options`` are those of `observable` that all have in common.
    """
    for name, (unit, meaning) in rows.items():
        observable(name, unit=unit, meaning=meaning, **options)(measure)


def function(
    name: str,
    *,
    parameters: Mapping[str, Any],
    returns: Mapping[str, tuple[str, str]],
    description: str = "",
    seconds: float = 1e-3,
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Declare a function that points of ``system: function`` call in place of a flow.

    The function below is called with a number for each of its parameters, by name, in the units
    declared. It returns a number, or a mapping of names to numbers; not-a-number where there is
    none. With an argument ``rng`` it depends on chance: that is a `numpy.random.Generator` of its
    own for each replicate of a point.

    Parameters
    ----------
    name : str
        What points call it.
    parameters : mapping
        Its parameters, made by `sim.parameters.choices.parameter`. Several functions may have one
        of a name, if they declare it alike.
    returns : mapping
        The observables that it returns, by name: unit, as UDUNITS reads it, and meaning.
    description : str
        What it is, in a few words, with its source.
    seconds : float
        Processor time of a call (s), about; points are shared out among processes by it.
    """
    what = f"function {name}"
    if clash := sorted(set(returns) & set(parameters)):
        raise AdditionError(f"{what}: returns {clash[0]}, which is one of its parameters")

    def register(make: Callable[..., Any]) -> Callable[..., Any]:
        takes_rng = callable(make) and RNG in signature(make).parameters
        require_function(what, make, 0, (*parameters, *([RNG] if takes_rng else [])))
        options: dict[str, Any] = {"description": description, "seconds": float(seconds)}
        options |= {"make": make, "parameters": dict(parameters), "returns": tuple(returns)}
        FUNCTION.add(name, Function, **options)
        # Run files have these numbers under their names.
        declare_observables(lambda run: run, returns, system=FUNCTION_NAME)
        return make

    return register


#: Kind of the additions that are forms.
_FORM = "form"

#: Gives an array (n,) from the parameters of points, by name, each an array (n,) or one value.
Column = Annotated[Callable[[Mapping[str, Any]], Any], takes(1)]


class Form(Declared):
    """An observable as a scale times a smooth function of groups of parameters.

    ``meaning`` is what it is in words, for captions, ``scale`` is in the unit of the observable.
    ``inputs`` are groups by name: one with the name of a parameter takes its place, others are
    added.
    """

    name: str
    systems: Systems
    observable: str
    meaning: Words
    scale: Column | None = None
    inputs: dict[str, Column] = {}


def form(name: str, *, system: str | Collection[str], **fields: Any) -> None:
    """Declare a form; a surrogate chooses among those of its system and observable by itself.

    ``fields`` are those of `Form`. Its functions get the parameters of points by name, in the units
    of study files.
    """
    systems = (system,) if isinstance(system, str) else tuple(system)
    add(_FORM, name, declared(Form, f"form {name}", name=name, systems=systems, **fields))


def require_observables(system: str, observables: Collection[str]) -> None:
    """Refuse forms of plug-ins for a system that are of none of its observables.

    It is asked once all plug-ins are loaded: any of them may declare the observable of a form.
    """
    for name, one in additions(_FORM).items():
        if system in one.value.systems:
            with attribute_errors_to(_FORM, name):
                require_one_of("observable", one.value.observable, observables)


def forms(system: str, observable: str) -> dict[str, Form]:
    """Return the forms of an observable by name; those of plug-ins come last."""
    # They ship beside the observables, which import NumPy.
    import_module("sim.measures")
    every: dict[str, Form] = {**shipped(_FORM)}
    every |= {name: one.value for name, one in additions(_FORM).items()}
    of_system = {name: one for name, one in every.items() if system in one.systems}
    return {name: one for name, one in of_system.items() if one.observable == observable}
