"""Observables: numbers per replicate that are computed from run files, and the calls that add them.

Those that ship are in `sim.measures`; plug-ins add more.
"""

from collections.abc import Callable, Collection, Mapping
from itertools import chain
from typing import Annotated, Any, TypeVar

from sim.base.additions import add
from sim.base.plugins import (
    Declared,
    Unit,
    Words,
    allowed,
    declared,
    require_function,
    require_one_of,
)
from sim.parameters.points import SYSTEMS
from sim.parameters.variables import OBSERVABLE, Measuring, Observable, reserved_names, variable

_Measuring = TypeVar("_Measuring", bound=Measuring)

#: Names in a dataset that are neither observables nor parameters.
_OF_DATASETS = {"point", "replicate", "series", "figures", "caveat", "particles", "boundaries"}


#: Systems, one at least.
Systems = Annotated[
    tuple[str, ...],
    allowed(
        f"one of {', '.join(SYSTEMS)}",
        lambda names: names and all(isinstance(one, str) and one in SYSTEMS for one in names),
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
