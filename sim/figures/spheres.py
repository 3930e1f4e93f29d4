"""Particles as circles, those nearest to the viewer last, and the flow of spheres down a plane."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize

from sim.study.plottable import LARGEST_PORTION

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
