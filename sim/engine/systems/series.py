"""The energy ledger of each system, and totals since the start."""

from typing import Any

import numpy as np

from sim.engine.observe.system import Ledger

CHUTE_LEDGER = Ledger(
    terms=dict.fromkeys(
        (
            "kinetic_energy",
            "rotational_energy",
            "potential_energy",
            "stored_energy",
            "normal_loss",
            "frictional_loss",
        ),
        1,
    ),
    turnover=("normal_loss", "frictional_loss"),
    powers={"normal_loss": "normal_power", "frictional_loss": "frictional_power"},
)

BELT_LEDGER = Ledger(
    terms={
        "kinetic_energy": 1,
        "potential_energy": 1,
        "stored_energy": 1,
        "normal_loss": 1,
        "shear_loss": 1,
        "belt_work": -1,
    },
    turnover=("belt_work",),
    powers={
        "normal_loss": "normal_power",
        "shear_loss": "shear_power",
        "belt_work": "belt_power",
    },
)


CONVEYOR_LEDGER = Ledger(
    terms=CHUTE_LEDGER.terms | {"plane_work": -1},
    turnover=CHUTE_LEDGER.turnover,
    powers=CHUTE_LEDGER.powers | {"plane_work": "plane_power"},
)


def total_since_start(system: Any, name: str, gained: np.ndarray) -> np.ndarray:
    """Return the total since the start at each of K samples, and store the last in the system.

    ``name`` is the attribute with the total so far, ``gained`` (K,) the gain of each sample.
    """
    total = np.cumsum([getattr(system, name), *gained])
    setattr(system, name, float(total[-1]))
    return total[1:]
