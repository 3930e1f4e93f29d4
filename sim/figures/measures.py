"""Measures of runs as figures draw them: means over replicates against a parameter."""

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd

from sim.base.errors import InputError
from sim.dataset.replicates import student_half_width
from sim.figures.caption import regime_sentence
from sim.figures.columns import parameter_columns
from sim.figures.summary import FigureData


def measured(data: FigureData, name: str, unit: str = "") -> pd.DataFrame:
    """Return the points with a measure in the place of their velocity, to draw it as one.

    ``velocity`` is the mean over the completed replicates in which the measure is known, and
    ``half_width`` its 95 % interval; a single one has no interval. Points of which nothing is known
    are left out.

    Parameters
    ----------
    data : FigureData
        What the figure is drawn from.
    name : str
        Measure in the dataset.
    unit : str
        Parameter that it is divided by, if any.

    Raises
    ------
    InputError
        When the dataset has no such measure.
    """
    if name not in data.results.dataset:
        raise InputError(f"no {name} in the dataset")
    values = data.results.dataset[name].sel(point=data.rows["point"].values).values
    if unit:
        values = values / data.rows[unit].to_numpy()[:, None]
    known = [each[np.isfinite(each)] for each in values]
    rows = data.rows.assign(
        velocity=[each.mean() if each.size else np.nan for each in known],
        half_width=[float(student_half_width(each)) for each in known],
    )
    return rows[rows["velocity"].notna()]


def measure_notes(data: FigureData) -> list[str]:
    """Return what a caption says of error bars and markers."""
    bars = "Error bars: Student's 95 % interval of the mean over replicates, none where only one."
    return [bars, regime_sentence(data.rows)]


def measure_table(
    data: FigureData, names: Iterable[str], measures: Mapping[str, pd.DataFrame]
) -> pd.DataFrame:
    """Return the data behind a figure of measures, one row per point.

    Parameters
    ----------
    data : FigureData
        What the figure is drawn from.
    names : iterable of str
        Parameters that the table gives.
    measures : mapping
        Points as `measured` returns them, by the heading ``what [unit]`` of their column.
    """
    rows, columns = data.rows, {}
    for heading, found in measures.items():
        unit = heading[heading.index("[") :]
        columns[heading] = found["velocity"].reindex(rows.index)
        half_width = found["half_width"].reindex(rows.index)
        label = "" if len(measures) == 1 else f" of the {heading.removesuffix(unit).strip()}"
        columns[f"half width of 95 % interval{label} {unit}"] = half_width
    return pd.DataFrame(
        parameter_columns(rows, rows["system"].iloc[0], names)
        | columns
        | {
            "completed replicates": rows["completed"],
            "regime": rows["regime"],
            "quality of the mean": rows["quality"],
        }
    )
