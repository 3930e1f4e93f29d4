"""Energy measure of one replicate of a run file: the share that its ledger lacks."""

from collections.abc import Mapping
from typing import Any

from sim.dataset.caveats import missing_energy


def measure(run: Mapping[Any, Any]) -> dict[str, float]:
    """Return the share of the energy turned over that the ledger lacks; empty without a ledger.

    See `sim.dataset.caveats.missing_energy`.
    """
    return {"missing_energy": missing_energy(run)} if "energy_residual" in run else {}
