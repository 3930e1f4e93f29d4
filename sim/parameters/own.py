"""Observables of plug-ins: name, unit and meaning, as the list of Talus' own has them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from sim.base.additions import add, additions
from sim.base.require import require_function, require_line, require_one_of
from sim.parameters.points import SYSTEMS
from sim.parameters.variables import Variable, observed, reserved_names

#: Gives an observable from the arrays of one replicate of a run.
Measuring = Callable[[Mapping[str, Any]], float]

#: Kind of these additions.
OBSERVABLE = "observable"

#: Names in a dataset that are neither observables nor parameters.
_OF_DATASETS = {"point", "replicate", "series", "figures", "caveat", "particles", "boundaries"}


@dataclass(frozen=True)
class OwnObservable:
    """A number per replicate that a plug-in computes for the runs of one system.

    ``measure`` gives it from the arrays of one replicate.
    """

    variable: Variable
    measure: Measuring


def observable(
    name: str, *, system: str, unit: str, meaning: str
) -> Callable[[Measuring], Measuring]:
    """Declare an observable: a number for each completed replicate of a run, kept in the dataset.

    The function below gets a mapping: time series (T,), profiles (H,) with their ``height`` (m),
    first and last state of the particles, scalars and parameters of one replicate, by their names
    in run files. It returns a number, not-a-number where there is none.

    Parameters
    ----------
    name : str
        What studies and datasets call it.
    system : str
        ``chute`` or ``belt``.
    unit : str
        As UDUNITS reads it; ``"1"`` for pure numbers.
    meaning : str
        What it is, for axes and captions.
    """
    require_one_of(f"observable {name}: system", system, SYSTEMS)
    require_line(f"observable {name}: unit", unit)
    require_line(f"observable {name}: meaning", meaning)

    def declared(measure: Measuring) -> Measuring:
        require_function(f"observable {name}", measure, takes=1)
        variable = observed(name, unit, meaning, system)
        add(OBSERVABLE, name, OwnObservable(variable, measure), _taken())
        return measure

    return declared


def own_observables(system: str | None = None) -> dict[str, OwnObservable]:
    """Return what plug-ins have declared, of one system or of all."""
    found = {name: one.value for name, one in additions(OBSERVABLE).items()}
    return {name: one for name, one in found.items() if system in (None, *one.variable.systems)}


def _taken() -> set[str]:
    """Return the names that variables of datasets, and what plots show, have already."""
    fields = {name for model in SYSTEMS.values() for name in model.model_fields}
    return reserved_names() | fields | _OF_DATASETS
