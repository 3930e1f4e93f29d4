"""A profile over the height above the belt, a curve per flow, as in Gallas' Figs. 2 and 3."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures.data import FigureData, parameter_columns, split_curves, varying_parameters
from sim.figures.family import labels_and_styles
from sim.figures.style import (
    PALE_LINE,
    canvas,
    legend_title,
    look_of,
    name_protocols,
    place_legend,
)
from sim.parameters import BeltParameters
from sim.study.plottable import profiles as observables

#: Number density (1/⟨d⟩²) of the emptiest slice at the top of a profile.
THIN = 0.01


class Profile(NamedTuple):
    """A profile over the height: its name in the dataset, and how data call it.

    In their units it is ``power`` powers of ⟨d⟩ times that of the dataset.
    """

    name: str
    heading: str
    power: int


DENSITY = Profile("number_density", "number density [⟨d⟩-2]", 2)
VELOCITY = Profile("velocity_profile", "mean velocity [m s-1]", 0)

#: The profiles by the names that figures give.
PROFILES = {"number_density": DENSITY, "velocity": VELOCITY}


def _profile(data: FigureData) -> Profile:
    name = data.spec.show
    observable = observables(data.spec.system)[name]
    usual = Profile(observable.source, f"{observable.meaning} [{observable.unit}]", 0)
    return PROFILES.get(name, usual)


def draw(data: FigureData) -> Figure:
    """Draw one profile of every flow."""
    profile = _profile(data)
    table = profiles(data, profile)
    figure, axes = canvas()
    _draw_flows(axes, data, table)
    axes.set_xlim(left=0)
    axes.set_ylim(*_range(table["mean"]))
    labels = data.spec.labels
    axes.set_xlabel(labels.get("x", "height above the belt z/⟨d⟩"))
    axes.set_ylabel(labels.get("y", profile.heading))
    named = data.spec.by
    place_legend(figure, axes, legend_title("belt", varying_parameters(data.rows, named)))
    return figure


def _draw_flows(axes: Axes, data: FigureData, table: pd.DataFrame) -> None:
    """Draw a line and a band per flow, those of the converged protocol pale beside published."""
    shown = data.rows[data.rows["completed"] > 0]
    beside = shown["protocol"].nunique() > 1
    keys = data.spec.by
    look = look_of(data.spec, keys)
    curves = split_curves(shown, "point", keys, tuple(BeltParameters.model_fields))
    labels, styles = labels_and_styles([names for names, _ in curves], look)
    for (_, flows), label in zip(curves, labels, strict=True):
        style = styles[label]
        pale: dict[str, Any] = (
            PALE_LINE if beside and flows["protocol"].iloc[0] == "converged" else {}
        )
        for point in flows["point"]:
            part = table[table["point"] == point]
            low, high = part["mean"] - part["half_width"], part["mean"] + part["half_width"]
            axes.plot(part["z"], part["mean"], color=style.colour, linestyle=style.dashes, **pale)
            axes.fill_between(part["z"], low, high, color=style.colour, alpha=0.15, linewidth=0)
    for label, style in styles.items():
        axes.plot([], [], color=style.colour, linestyle=style.dashes, label=label)
    if beside:
        name_protocols(axes, "belt")


def _range(means: pd.Series) -> tuple[float, float]:
    """Return the range of the vertical axis: that of the curves, however wide their bands are."""
    low, high = min(0.0, means.min()), max(0.0, means.max())
    room = 0.08 * (high - low) if high > low else 1.0
    return (low - room if low else 0.0), high + room


def profiles(data: FigureData, profile: Profile) -> pd.DataFrame:
    """Return the profiles of all points that have a completed replicate.

    Returns
    -------
    pandas.DataFrame
        A row per point and slice, up to the last slice that is not thinner than `THIN`: ``point``,
        ``z`` (⟨d⟩), ``mean`` and ``half_width`` (of its 95 % interval over the replicates; NaN for
        a single one). A slice that is empty in a replicate has no velocity.
    """
    parts = []
    for row in data.rows[data.rows["completed"] > 0].to_dict("records"):
        values, height = data.results.profile(row["point"], profile.name)
        density, _ = data.results.profile(row["point"], DENSITY.name)
        dense = np.flatnonzero(density.mean(axis=0) * row["diameter"] ** 2 >= THIN)
        end = dense.max(initial=-1) + 1
        values = values[:, :end] * row["diameter"] ** profile.power
        half_width = student_half_width(values)
        parts.append(
            pd.DataFrame(
                {
                    "point": row["point"],
                    "z": height[:end] / row["diameter"],
                    "mean": values.mean(axis=0),
                    "half_width": half_width,
                }
            )
        )
    return pd.concat(parts or [pd.DataFrame(columns=["point", "z", "mean", "half_width"])])


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind a panel: a row per point and slice, units in the headings."""
    profile, names = _profile(data), (*data.spec.named, "initial_velocity", "protocol")
    columns = parameter_columns(data.rows, "belt", names)
    slices = profiles(data, profile).rename(
        columns={
            "z": "height above the belt [⟨d⟩]",
            "mean": profile.heading,
            "half_width": f"half width of 95 % interval {profile.heading.split()[-1]}",
        }
    )
    points = pd.DataFrame(columns | {"completed replicates": data.rows["completed"]})
    return points.merge(slices, on="point", how="inner")


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on bands, slices and their extent."""
    has_bands = (data.rows["completed"] > 1).any()
    return [
        "Bands: 95 % intervals of the mean over replicates (Student), which may go beyond the "
        "axes; none where one replicate is known."
        if has_bands
        else "",
        "z is measured from the present position of the belt, in slices of ⟨d⟩, up to the last one "
        f"with {THIN:g} beads per ⟨d⟩² or more; one that is empty in a replicate has no velocity.",
    ]
