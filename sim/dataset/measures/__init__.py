"""Measures: numbers per replicate that a dataset adds to those of its run files."""

import numpy as np

from sim.base.additions import blamed
from sim.dataset.measures import belt, chute, conveyor, energy
from sim.dataset.run_file import Replicate, RunFile
from sim.parameters.own import OBSERVABLE, OwnObservable, own_observables
from sim.parameters.variables import variables

_OF_SYSTEM = {"chute": chute, "belt": belt, "conveyor": conveyor}


def measures(run: RunFile) -> dict[str, np.ndarray]:
    """Return the measures of a run, and observables of plug-ins, each an array over its replicates.

    Replicates that failed, and files without the arrays that a measure needs, give not-a-number.
    """
    name, status = run.attrs["system"], run["status"]
    system, own = _OF_SYSTEM[name], own_observables(name)
    names = (*variables("measure", system=name), *own)
    table = {name: np.full(len(status), np.nan) for name in names}
    point = run.attrs["point_id"]
    for index in np.flatnonzero(status == "completed"):
        replicate = Replicate(run, int(index))
        found = energy.measure(replicate) | system.measure(replicate)
        found |= {name: _own(one, name, replicate, point) for name, one in own.items()}
        for name, value in found.items():
            table[name][index] = value
    return table


def _own(one: OwnObservable, name: str, replicate: Replicate, point: str) -> float:
    """Return an observable of a plug-in, whose mistakes must not look like those of the file."""
    with blamed(OBSERVABLE, name, f" of {point}"):
        return float(one.measure(replicate))
