"""Columns of the tables of data behind figures."""

from collections.abc import Iterable

import pandas as pd

from sim.parameters import SYSTEMS, field_info


def parameter_columns(
    rows: pd.DataFrame, system: str, names: Iterable[str]
) -> dict[str, pd.Series]:
    """Return the ids of points and some of their parameters, units in the headings."""
    declared = field_info(SYSTEMS[system])
    columns = {"point": rows["point"]}
    for name in names:
        row = declared[name]
        unit = row.scale or row.unit
        columns[f"{name} [{unit}]" if unit else name] = rows[name]
    return columns
