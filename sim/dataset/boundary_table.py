"""The table of boundaries in a dataset."""

from pathlib import Path

import netCDF4
import pandas as pd
import xarray as xr

from sim.base.seals import checked_read
from sim.dataset.added import added_columns

#: Group of the dataset with the table, one row per boundary.
GROUP = "boundaries"

#: Columns with the results of a boundary, and all columns of a table without rows.
RESULT_COLUMNS = ("low", "high", "below", "above", "verdict", "points")
_COLUMNS = ("name", "system", "of", "along", "unit", "figures", *RESULT_COLUMNS)


def read_table(dataset: Path) -> pd.DataFrame:
    """Read the table of boundaries from a dataset; it has no rows where the dataset has no table.

    Raises
    ------
    InputError
        When there is no dataset, or it is damaged. A damaged dataset of a study is set aside.
    """
    with checked_read(dataset, "dataset", replaceable=is_study_dataset(dataset), sealed=True):
        with netCDF4.Dataset(dataset) as file:
            if GROUP not in file.groups:
                return pd.DataFrame(columns=_COLUMNS)
        with xr.open_dataset(dataset, engine="netcdf4", group=GROUP) as group:
            table = group.to_dataframe()
    return table.assign(**added_columns({name: table[name].to_numpy() for name in table}))


def is_study_dataset(dataset: Path) -> bool:
    """Return whether a dataset lies where the workflow makes it, next to its runs."""
    return dataset.name == "dataset.nc" and (dataset.parent / "runs").is_dir()
