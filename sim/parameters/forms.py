"""Forms that the physics of a system suggests for an observable between points."""

from collections.abc import Callable, Collection, Mapping
from importlib import import_module
from typing import Annotated, Any

from sim.base.additions import add, additions, attribute_errors_to, shipped
from sim.base.plugins import Declared, Words, declared, require_one_of, takes
from sim.parameters.observables import Systems

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
