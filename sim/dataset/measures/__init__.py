"""Measures: numbers per replicate that a dataset adds to those of its run files."""

import numpy as np

from sim.dataset.measures import belt, chute, energy
from sim.dataset.run_file import Replicate, RunFile
from sim.parameters.observables import BELT_MEASURES, CHUTE_MEASURES, ENERGY_MEASURES

_OF_SYSTEM = {"chute": (chute, CHUTE_MEASURES), "belt": (belt, BELT_MEASURES)}


def measures(run: RunFile) -> dict[str, np.ndarray]:
    """Return the measures of a run, each an array over its replicates.

    Replicates that failed, and files without the arrays that a measure needs, give not-a-number.
    """
    (system, names), status = _OF_SYSTEM[run.attrs["system"]], run["status"]
    table = {name: np.full(len(status), np.nan) for name in ENERGY_MEASURES | names}
    for index in np.flatnonzero(status == "completed"):
        replicate = Replicate(run, int(index))
        found = energy.measure(replicate) | system.measure(replicate)
        for name, value in found.items():
            table[name][index] = value
    return table
