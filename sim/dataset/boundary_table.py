"""The table of boundaries that a dataset holds."""

from pathlib import Path

import netCDF4
import pandas as pd
import xarray as xr

from sim.base.damage import checked_read
from sim.dataset.added import with_added

#: Group of the dataset that holds what was found, one row per boundary.
GROUP = "boundaries"

#: Columns that say what was found, and all that a table without rows has.
FOUND = ("low", "high", "below", "above", "verdict", "points")
_COLUMNS = ("name", "system", "of", "along", "unit", "figures", *FOUND)


def read_table(dataset: Path) -> pd.DataFrame:
    """Read the table of boundaries from a study's dataset; without rows where there is none.

    Raises
    ------
    InputError
        When there is no dataset, or it is damaged. That of a study is then set aside.
    """
    with checked_read(dataset, "dataset", replaceable=is_of_study(dataset), sealed=True):
        with netCDF4.Dataset(dataset) as file:
            if GROUP not in file.groups:
                return pd.DataFrame(columns=_COLUMNS)
        with xr.open_dataset(dataset, engine="netcdf4", group=GROUP) as found:
            table = found.to_dataframe()
    return table.assign(**with_added({name: table[name].to_numpy() for name in table}))


def is_of_study(dataset: Path) -> bool:
    """Return whether a dataset lies where the workflow makes it, beside its runs."""
    return dataset.name == "dataset.nc" and (dataset.parent / "runs").is_dir()
