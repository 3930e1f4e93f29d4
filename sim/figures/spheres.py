"""Particles as circles, and flows of spheres down a plane with their profiles, as Walton's."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from sim.base.errors import InputError, upper_first
from sim.figures.caption import velocity_text
from sim.figures.data import FigureData, split_curves
from sim.figures.style import DOTTED, PALE, cycle_style, escape_label, legend_above
from sim.parameters import SYSTEMS, default_of
from sim.parameters.roles import start_parameters
from sim.parameters.words import PROTOCOLS, setting
from sim.study.plottable import LARGEST_PORTION, SHARE

COLOURS = colormaps["viridis"]
DARK = "#222222"

#: Of a shaded sphere: circles that it is drawn as, brightness of the outermost, and how far the
#: innermost one is towards the light, to the right and up, in radii.
_CIRCLES, _RIM = 6, 0.35
_LIGHT = np.array([-0.3, 0.45])

#: Where the viewer of a chute stands, degrees: a little down the slope and above.
AZIMUTH, ELEVATION = -16.0, 14.0

_FLOOR, _GLUED = (0.86, 0.84, 0.80), (0.6, 0.6, 0.6, 1.0)

_ARROW: dict[str, Any] = {
    **{"color": DARK, "fontsize": 8.5, "annotation_clip": False},
    "arrowprops": {"arrowstyle": "-|>", "color": DARK, "linewidth": 1.2, "shrinkA": 0},
}


def draw_particles(
    axes: Axes,
    place: np.ndarray,
    size: np.ndarray,
    colour: np.ndarray,
    depth: np.ndarray | None = None,
    *,
    shaded: bool = False,
    **look: Any,
) -> EllipseCollection:
    """Draw particles to scale: centres (N, 2), diameters (N,) and colours (N, 4).

    ``depth`` (N,) is how near to the viewer they are; the nearer ones hide the others. ``shaded``
    particles look like spheres in a light. ``look`` are options of the circles, as their edges.
    """
    if depth is not None:
        order = np.argsort(depth, kind="stable")
        place, size, colour = place[order], size[order], colour[order]
    if shaded:
        inward = np.linspace(0, 1, _CIRCLES, endpoint=False)[:, None]
        moved = place[:, None] + size[:, None, None] / 2 * inward * _LIGHT
        bright = np.append(np.repeat(_RIM + (1.15 - _RIM) * inward**0.5, 3, axis=1), inward >= 0, 1)
        colour = np.clip(colour[:, None] * bright, 0, 1).reshape(-1, 4)
        place, size = moved.reshape(-1, 2), (size[:, None] * (1 - inward[:, 0])).ravel()
        look = {"linewidths": 0, "rasterized": True} | look
    circles = EllipseCollection(
        size,
        size,
        np.zeros_like(size),
        units="xy",
        offsets=place,
        offset_transform=axes.transData,
        facecolors=colour,
        **look,
    )
    axes.add_collection(circles)
    return circles


def across_sides(x: np.ndarray, size: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Return indices and places along x of particles in a period.

    Particles across one of its sides are at both. ``x`` and ``size`` are (N,).
    """
    x = np.mod(x, period)
    sides = [np.flatnonzero(x < size / 2), np.flatnonzero(x > period - size / 2)]
    index = np.concatenate([np.arange(len(x)), *sides])
    shift = np.repeat([0.0, period, -period], [len(x), *map(len, sides)])
    return index, x[index] + shift


def view_from(azimuth: float, elevation: float, slope: float = 0.0) -> np.ndarray:
    """Return the unit vectors (3, 3) to the right and up in a picture, and toward the viewer.

    Angles are in degrees: of the viewer, who looks along y with z up, round towards negative x, and
    above the horizontal; ``slope`` is how far x points below the horizontal of the picture.
    """
    a, e, s = np.radians([azimuth, elevation, slope])
    right = np.array([np.cos(a), -np.sin(a), 0.0])
    toward = np.array([-np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
    level = np.stack([right, np.cross(toward, right), toward])
    return level @ np.array([[np.cos(s), 0, np.sin(s)], [0, 1, 0], [-np.sin(s), 0, np.cos(s)]])


class Scene:
    """The view, the shown part of the cell, and the colours that all pictures of a flow share.

    ``row`` and ``state`` are a point and its particles, ``heights`` (m) those for which pictures
    need room, and ``speeds`` (m/s) the velocities down the slope that span the range of colours.
    """

    def __init__(
        self, row: Mapping[str, Any], state: xr.Dataset, heights: np.ndarray, speeds: np.ndarray
    ):
        self.diameter = float(row["diameter"])
        self.cell = np.array([row["cell"], row["cell_across"] or row["cell"]], float)
        self.shown_size = self.cell * (1.0, 0.5 if row["depth"] <= LARGEST_PORTION else 1.0)
        self.size = 2 * state["radius"].values / self.diameter
        glued = state["fixed"].values if "fixed" in state else np.zeros(len(self.size))
        self.is_glued = glued.astype(bool)
        self.view = view_from(AZIMUTH, ELEVATION, row["angle"])
        self.top = float(heights.max(initial=0.0)) / self.diameter
        # The least range gives spheres at rest one colour despite rounding errors.
        slow, fast = np.percentile(speeds, (1, 99))
        least = 0.05 * np.sqrt(row["gravity"] * self.diameter)
        self.norm = Normalize(float(slow), float(max(fast, slow + least)))

    def draw(self, axes: Axes, position: np.ndarray, speed: np.ndarray) -> EllipseCollection:
        """Draw spheres at ``position`` (N, 3), m, coloured by ``speed`` (N,), m/s.

        Spheres are at their periodic images in the cell. Those glued to the plane are grey.
        """
        place = position / self.diameter
        place[:, :2] %= self.cell
        is_shown = (place[:, :2] < self.shown_size).all(axis=1)
        colour = np.where(self.is_glued[:, None], _GLUED, COLOURS(self.norm(speed)))[is_shown]
        seen = place[is_shown] @ self.view.T
        return draw_particles(
            axes, seen[:, :2], self.size[is_shown], colour, seen[:, 2], shaded=True, zorder=2
        )

    def prepare(self, axes: Axes) -> None:
        """Draw the plane, arrows of flow and gravity, and a colour bar, in units of σ."""
        axes.set(xticks=[], yticks=[], anchor="W", aspect="equal")
        axes.spines[:].set_visible(False)
        axes.grid(visible=False)
        (x0, y0), (x1, y1) = -np.ones(2), self.shown_size + 1
        ground = np.array([(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)]) @ self.view.T
        axes.fill(*ground[:, :2].T, color=_FLOOR, zorder=1)
        above = ground + self.top * self.view[:, 2]
        corners = np.concatenate([ground, above])[:, :2]
        (left, bottom), (right, top) = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
        length = 0.17 * max(right - left, top - bottom)
        # In front of the plane, and at the right.
        start, end = (np.array([(0, -2.3, 0), (length, -2.3, 0)]) @ self.view.T)[:, :2]
        aside = right - 0.3 * length
        axes.annotate("flow", end, start, ha="right", va="top", **_ARROW)
        axes.annotate("g", (aside, top - length), (aside, top), ha="center", **_ARROW)
        axes.set(xlim=(min(left, start[0] - length), right), ylim=(bottom - 0.7 * length, top))
        shades = ScalarMappable(self.norm, COLOURS)
        look: dict[str, Any] = {"shrink": 0.55, "aspect": 22}
        label = "velocity of spheres u (m/s)"
        axes.figure.colorbar(shades, ax=axes, pad=0.02, label=label, **look)


# A chute flow as in Walton's Figs. 1.1 to 1.6: profiles of velocity and packing, and spheres.

#: How the profile of a replicate is drawn.
_REPLICATE: dict[str, Any] = {"alpha": PALE, "linewidth": 0.7, "zorder": 1.5}


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of each flow that is drawn."""
    return [
        "Pale: single replicates; instantaneous profiles and (c) are of the first flow.",
        *(
            f"{upper_first(label)}: mean velocity {velocity_text(row)} (95 % interval), "
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
        values, colour = profile(data, row), cycle_style(index).colour
        suffix = f", {label}" if len(flows) > 1 else ""
        for axes, name in zip(panels, ("velocity", "packing"), strict=True):
            if index == 0:
                latest, look = values[f"{name}_instantaneous"], {"label": "instantaneous"}
                axes.plot(latest, values["z"], color="black", linewidth=1.0, **look)
            _draw_averages(axes, values, name, colour, suffix)
    _finish(panels, data.rows.iloc[0])
    if flows:
        panels[0].plot([], [], label="each replicate", color="black", **_REPLICATE)
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
