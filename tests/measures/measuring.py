"""The observables that the arrays of a made-up replicate allow."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.dataset.gather import measure
from sim.parameters.variables import observables


def measured(run: Mapping[Any, Any], system: str) -> dict[str, float]:
    """Return the observables of a replicate that have a value."""
    values = measure(run, observables(system), "a point")
    return {name: value for name, value in values.items() if not np.isnan(value)}
