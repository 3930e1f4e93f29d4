"""Quantities of points as curves show them: values with their 95 % intervals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sim.base.errors import InputError
from sim.base.statistics import student_half_width
from sim.figures.data import FigureData, parameter_columns


@dataclass(frozen=True)
class Quantity:
    """A quantity of every point of a figure.

    Attributes
    ----------
    name : str
        Column or measure that it is from.
    label : str
        What it is, with its unit: ``what [unit]``.
    value, half_width : pandas.Series
        Of each row of the points; not-a-number where it, or its 95 % interval, is not known.
    """

    name: str
    label: str
    value: pd.Series
    half_width: pd.Series


def velocity(rows: pd.DataFrame) -> Quantity:
    """Return the mean velocity of points."""
    return Quantity("velocity", "mean velocity [m s-1]", rows["velocity"], rows["half_width"])


def measured(data: FigureData, name: str, label: str, over: str = "") -> Quantity:
    """Return a measure of the dataset: its mean over the completed replicates that know it.

    Parameters
    ----------
    data : FigureData
        What the figure is drawn from.
    name : str
        Measure in the dataset.
    label : str
        What it is, ``what [unit]``.
    over : str
        Parameter that it is divided by, if any.

    Raises
    ------
    InputError
        When the dataset has no such measure.
    """
    rows, dataset = data.rows, data.results.dataset
    if name not in dataset:
        raise InputError(f"no {name} in the dataset")
    values = dataset[name].sel(point=rows["point"].values).values
    if over:
        values = values / rows[over].to_numpy()[:, None]
    return of_replicates(name, label, [each[np.isfinite(each)] for each in values], rows.index)


def of_replicates(name: str, label: str, values: Sequence[np.ndarray], index: pd.Index) -> Quantity:
    """Return the means, over the values (R,) of each point, of a quantity."""
    return Quantity(
        name,
        label,
        pd.Series([each.mean() if each.size else np.nan for each in values], index, dtype=float),
        pd.Series([float(student_half_width(each)) for each in values], index, dtype=float),
    )


def measures(data: FigureData) -> list[Quantity]:
    """Return the ``quantities`` that the options of a figure name."""
    return [
        measured(data, each["name"], each["label"], each.get("over", ""))
        for each in data.spec.options["quantities"]
    ]


def measure_table(data: FigureData) -> pd.DataFrame:
    """Return the data behind a figure of measures, one row per point, units in the headings."""
    return quantity_table(data, measures(data))


def quantity_table(
    data: FigureData, quantities: Sequence[Quantity], along: dict[str, pd.Series] | None = None
) -> pd.DataFrame:
    """Return parameters and quantities of points, one row each, units in the headings.

    Parameters
    ----------
    data : FigureData
        What the figure is drawn from.
    quantities : sequence of Quantity
        Those of its rows.
    along : dict, optional
        Columns between parameters and quantities, by their headings.
    """
    rows, columns = data.rows, dict(along or {})
    for each in quantities:
        what, unit = each.label[: each.label.index("[")], each.label[each.label.index("[") :]
        of = "" if len(quantities) == 1 else f" of the {what.strip()}"
        columns[each.label] = each.value
        columns[f"half width of 95 % interval{of} {unit}"] = each.half_width
    spec = data.spec
    return pd.DataFrame(
        parameter_columns(rows, spec.system, (*spec.axes, *spec.named, "protocol"))
        | columns
        | {
            "completed replicates": rows["completed"],
            "regime": rows["regime"],
            "quality of the mean": rows["quality"],
        }
    )
