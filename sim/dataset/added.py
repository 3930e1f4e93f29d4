"""Parameters that have been added since a dataset was made."""

from collections.abc import Mapping

import numpy as np

from sim.parameters import SYSTEMS, unsaid


def with_added(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns of all added parameters, with their defaults where rows have no value.

    Parameters
    ----------
    columns : mapping
        Arrays over rows: ``system`` and parameters, NaN or ``""`` where a row has none.
    """
    systems = np.asarray(columns["system"])
    found: dict[str, np.ndarray] = {}
    for system in sorted(set(systems) & SYSTEMS.keys()):
        for name, default in unsaid(system).items():
            word = isinstance(default, str)
            kind, none = (object, "") if word else (float, np.nan)
            values = found.get(name, columns.get(name, np.full(len(systems), none, kind)))
            blank = values == "" if word else np.isnan(values)
            found[name] = np.where((systems == system) & blank, default, values)
    return found
