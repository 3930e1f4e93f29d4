"""Measures: numbers per replicate that a dataset has in addition to those of run files."""

import numpy as np

from sim.base.additions import attribute_errors_to
from sim.dataset.measures import belt, chute, conveyor, energy
from sim.dataset.run_file import Replicate, RunFile
from sim.parameters.own import OBSERVABLE, OwnObservable, own_observables
from sim.parameters.variables import variables_of

_SYSTEM_MEASURES = {"chute": chute, "belt": belt, "conveyor": conveyor}


def measures(run: RunFile) -> dict[str, np.ndarray]:
    """Return measures and plug-in observables of a run, each an array over its replicates.

    Failed replicates, and files without the arrays that a measure needs, give not-a-number.
    """
    name, status = run.attrs["system"], run["status"]
    system, observables = _SYSTEM_MEASURES[name], own_observables(name)
    names = (*variables_of("measure", system=name), *observables)
    table = {name: np.full(len(status), np.nan) for name in names}
    point = run.attrs["point_id"]
    for index in np.flatnonzero(status == "completed"):
        replicate = Replicate(run, int(index))
        values = energy.measure(replicate) | system.measure(replicate)
        values |= {
            name: _plugin_value(observable, name, replicate, point)
            for name, observable in observables.items()
        }
        for name, value in values.items():
            table[name][index] = value
    return table


def _plugin_value(observable: OwnObservable, name: str, replicate: Replicate, point: str) -> float:
    """Return an observable of a plug-in; its errors are reported as those of the plug-in."""
    with attribute_errors_to(OBSERVABLE, name, f" of {point}"):
        return float(observable.measure(replicate))
