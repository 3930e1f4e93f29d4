"""A chute flow as in Walton's Figs. 1.1 to 1.6: profiles of velocity and packing, and spheres."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim.base.errors import InputError
from sim.figures.caption import velocity_text
from sim.figures.data import FigureData, split_curves
from sim.figures.spheres import Scene
from sim.figures.style import COLOURS, DOTTED, PALE, escape_label, legend_above
from sim.parameters import SYSTEMS, default_of
from sim.parameters.roles import start_parameters
from sim.parameters.words import PROTOCOLS, setting
from sim.study.plottable import LARGEST_PORTION, SHARE

#: How the profile of a replicate is drawn.
_REPLICATE: dict[str, Any] = {"alpha": PALE, "linewidth": 0.7, "zorder": 1.5}


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of each flow that is drawn."""
    return [
        "Pale: single replicates; instantaneous profiles and (c) are of the first flow.",
        *(
            f"{label[0].upper()}{label[1:]}: mean velocity {velocity_text(row)} (95 % interval), "
            f"{row['regime']}; replicates: {row['completed']:g}."
            for label, row in _flows(data)
        ),
    ]


def _flows(data: FigureData) -> list[tuple[str, dict[str, Any]]]:
    """Return label and row of the points with a completed replicate.

    Those of fixed lengths come first, and of them those in the usual cell.
    """
    rows = data.rows[data.rows["completed"] > 0]
    chute, flows = SYSTEMS["chute"], []
    candidates = (*start_parameters(chute), "stiffness")
    varied = [name for name in candidates if rows[name].nunique() > 1]
    keys = ("protocol", *varied)
    for names, points in split_curves(rows, "point", keys, tuple(chute.model_fields)):
        protocol, *others = (setting("chute", *item) for item in names.items())
        protocol = PROTOCOLS["chute"][names["protocol"]]
        flows += [(", ".join([protocol, *others]), row) for row in points.to_dict("records")]

    def order(flow: tuple[str, dict[str, Any]]) -> tuple[bool, int]:
        row = flow[1]
        unusual = sum(row[name] != default_of(chute, name, row) for name in varied)
        return row["protocol"] != "published", unusual

    return sorted(flows, key=order)


def draw(data: FigureData) -> Figure:
    """Draw the row of a depth: runs of a fixed length, and converged ones beside them."""
    flows = _flows(data)
    # A deep flow is a tall picture.
    height = 3.6 if data.rows["depth"].iloc[0] <= LARGEST_PORTION else 4.8
    figure = Figure(figsize=(7.4, height), layout="constrained")
    ((left, right),) = figure.subfigures(1, 2, squeeze=False, width_ratios=(1.35, 1))
    panels = left.subplots(1, 2, sharey=True)
    for index, (label, row) in enumerate(flows):
        values, colour = profile(data, row), COLOURS[index % len(COLOURS)]
        suffix = f", {label}" if len(flows) > 1 else ""
        for axes, name in zip(panels, ("velocity", "packing"), strict=True):
            if index == 0:
                latest, look = values[f"{name}_instantaneous"], {"label": "instantaneous"}
                axes.plot(latest, values["z"], color=COLOURS[0], linewidth=1.0, **look)
            _draw_averages(axes, values, name, colour, suffix)
    _finish(panels, data.rows.iloc[0])
    if flows:
        panels[0].plot([], [], label="each replicate", color=COLOURS[0], **_REPLICATE)
        _draw_configuration(right.subplots(), data, flows[0][1])
        legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def profile(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return the profiles of a point, a row per slice, up to the height of its last spheres.

    Columns ``z`` (σ) and, of ``velocity`` (m/s) and ``packing``, the cumulative average, that of
    each completed replicate (``_0``, ``_1`` and so on) and the ``_instantaneous`` value of the
    first one.
    """
    columns: dict[str, Any] = {}
    for name in ("packing", "velocity"):
        values, height = data.results.profile(row["point"], f"{name}_profile")
        columns["z"] = height / row["diameter"]
        columns[name] = values.mean(axis=0)
        columns |= {f"{name}_{index}": one for index, one in enumerate(values)}
        latest, _ = data.results.profile(row["point"], f"{name}_profile_instantaneous")
        columns[f"{name}_instantaneous"] = latest[0]
    filled = np.cumsum(columns["packing"]) / columns["packing"].sum()
    return pd.DataFrame(columns)[: int(np.searchsorted(filled, SHARE)) + 1]


def _draw_averages(axes: Axes, values: pd.DataFrame, name: str, colour: str, suffix: str) -> None:
    """Draw the time averages of the replicates and their mean; its suffix names one of several."""
    for each in _replicates(values, name):
        axes.plot(values[each], values["z"], color=colour, **_REPLICATE)
    label, z = escape_label(f"average{suffix}"), values["z"]
    axes.plot(values[name], z, color=colour, linestyle=DOTTED, linewidth=1.8, label=label)


def _replicates(values: pd.DataFrame, name: str) -> list[str]:
    """Return the columns of a profile that hold the replicates'."""
    return [column for column in values if column.removeprefix(f"{name}_").isdigit()]


def _finish(panels: np.ndarray, row: Mapping[str, Any]) -> None:
    velocity, packing = panels
    unit = float(np.sqrt(row["gravity"] * row["diameter"]))
    top = velocity.secondary_xaxis("top", functions=(lambda v: v / unit, lambda v: v * unit))
    top.set_xlabel("u / √(gσ)")
    velocity.set_xlabel("velocity u (m/s)\n(a)")
    velocity.set_ylabel("height z/σ")
    velocity.set_ylim(bottom=0)
    packing.set_xlabel("packing fraction φ\n(b)")
    for axes in panels:
        axes.set_xlim(0, max(1.15 * axes.dataLim.x1, 1e-6))


def _draw_configuration(axes: Axes, data: FigureData, row: Mapping[str, Any]) -> None:
    try:
        state = data.results.particles(row["point"])
    except InputError:
        axes.text(0.5, 0.5, "no configuration stored", ha="center", transform=axes.transAxes)
        axes.set_axis_off()
        return
    position, speed = state["position"].values, state["particle_velocity"].values[:, 0]
    scene = Scene(row, state, position[:, 2], speed)
    scene.prepare(axes)
    scene.draw(axes, position, speed)
    axes.set_xlabel("(c)")


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the profiles, a row per point and slice, units in the headings."""
    parts = []
    for label, row in _flows(data):
        values = profile(data, row)
        columns = {
            "point": row["point"],
            "flow": label,
            "depth [1]": row["depth"],
            "completed replicates": row["completed"],
            "regime": row["regime"],
            "height [σ]": values["z"],
        }
        columns |= _headed(values, "velocity", "m s-1") | _headed(values, "packing", "1")
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts) if parts else pd.DataFrame(columns=["point", "flow"])


def _headed(values: pd.DataFrame, name: str, unit: str) -> dict[str, pd.Series]:
    return {
        f"{name}, cumulative average [{unit}]": values[name],
        f"{name}, instantaneous [{unit}]": values[f"{name}_instantaneous"],
        **{
            f"{name}, replicate {index + 1} [{unit}]": values[each]
            for index, each in enumerate(_replicates(values, name))
        },
    }
