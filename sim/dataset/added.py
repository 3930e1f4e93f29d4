"""Parameters that have been added since a dataset was made, and those that nobody knows here."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from sim.base.errors import InputError
from sim.parameters import SYSTEMS, unsaid
from sim.parameters.choices import own


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


def require_known_options(held: xr.Dataset, path: Path) -> None:
    """Refuse points whose laws or motions have parameters that nothing is known of.

    Two that differ in such a one would be taken for the same.
    """
    for choice in ("law", "motion"):
        loaded = own(choice)
        for name in map(str, held[choice].values if choice in held.coords else ()):
            # Names of plug-ins' options end in their hashes.
            if "." in name and name not in loaded:
                allowed = "one of Talus, or of a plug-in that TALUS_PLUGINS names"
                raise InputError.of_value(str(path), choice, name, allowed)
