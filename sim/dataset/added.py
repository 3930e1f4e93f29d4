"""Parameters that were added after a dataset was made, and options of unknown plug-ins."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from sim.base.additions import plugin_options
from sim.base.errors import InputError
from sim.parameters import SYSTEMS, defaults_of_added


def added_columns(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns of all added parameters, with the default where a row has no value.

    Parameters
    ----------
    columns : mapping
        Arrays over rows: ``system`` and parameters, NaN or ``""`` where a row has none.
    """
    systems = np.asarray(columns["system"])
    filled: dict[str, np.ndarray] = {}
    for system in sorted(set(systems) & SYSTEMS.keys()):
        for name, default in defaults_of_added(system).items():
            is_text = isinstance(default, str)
            kind, none = (object, "") if is_text else (float, np.nan)
            values = filled.get(name, columns.get(name, np.full(len(systems), none, kind)))
            blank = values == "" if is_text else np.isnan(values)
            filled[name] = np.where((systems == system) & blank, default, values)
    return filled


def require_known_options(dataset: xr.Dataset, path: Path) -> None:
    """Refuse points with laws or motions of plug-ins that are not loaded.

    Their parameters are not known, so two points that differ in one would be taken for the same.
    """
    for choice in ("law", "motion"):
        loaded = plugin_options(choice)
        for name in map(str, dataset[choice].values if choice in dataset.coords else ()):
            # The name of an option of a plug-in ends in its hash.
            if "." in name and name not in loaded:
                allowed = "one of Talus, or of a plug-in that TALUS_PLUGINS names"
                raise InputError.of_value(str(path), choice, name, allowed)
