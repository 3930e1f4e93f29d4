"""A configuration of a chute flow: shaded spheres on the inclined plane, seen from the side."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from sim.figures.spheres import frame_around, picture, project, view_from
from sim.study.figure_spec import LARGEST_PORTION

#: Where the viewer stands: a little down the slope and above.
AZIMUTH, ELEVATION = -16.0, 14.0

COLOURS = colormaps["viridis"]
_GLUED_COLOUR = np.array([0.6, 0.6, 0.6])

DARK = "#222222"
_TEXT: dict[str, Any] = {"color": DARK, "fontsize": 8.5}
_ARROW: dict[str, Any] = {
    "arrowstyle": "-|>",
    "color": DARK,
    "linewidth": 1.2,
    "shrinkA": 0,
    "shrinkB": 0,
}


class Scene:
    """The view, the shown part of the cell, and the colours that all pictures of a flow share.

    Parameters
    ----------
    row : mapping
        Parameters of the point.
    state : xarray.Dataset
        Its particles, see `sim.dataset.results.Results.particles`.
    heights : numpy.ndarray
        Heights (m) for which the pictures need room, of any shape.
    speeds : numpy.ndarray
        Velocities down the slope (m/s) that span the range of colours, of any shape.
    pixels : int
        Height or width of the pictures in pixels, whichever is larger.
    """

    def __init__(
        self,
        row: Mapping[str, Any],
        state: xr.Dataset,
        heights: np.ndarray,
        speeds: np.ndarray,
        pixels: int,
    ):
        self.diameter = float(row["diameter"])
        self.cell = np.full(2, row["cell"] * self.diameter)
        self.shown_size = self.cell * (1.0, 0.5 if row["depth"] <= LARGEST_PORTION else 1.0)
        self.radius = state["radius"].values
        glued = state["fixed"].values if "fixed" in state else np.zeros(len(self.radius))
        self.is_glued = glued.astype(bool)
        self.view = view_from(AZIMUTH, ELEVATION, row["angle"])
        margin = self.diameter * np.array([[-1.0], [1.0]])
        self.floor = np.array([np.zeros(2), self.shown_size]) + margin
        (x0, y0), (x1, y1) = self.floor
        top = float(heights.max(initial=0.0))
        corners = [(x, y, z) for x in (x0, x1) for y in (y0, y1) for z in (0.0, top)]
        self.frame = frame_around(self.view, np.array(corners), 0.5 * self.diameter)
        left, right, bottom, upper = self.frame
        self.pixel = max(right - left, upper - bottom) / pixels
        # The least range gives spheres at rest one colour despite rounding errors.
        slow, fast = np.percentile(speeds, (1, 99))
        fast = max(fast, slow + 0.05 * np.sqrt(row["gravity"] * self.diameter))
        self.range = float(slow), float(fast)
        self.norm = Normalize(*self.range)

    def picture(self, position: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Return the picture (H, W, 4) of spheres at ``position`` (N, 3), m, coloured by ``speed``.

        ``speed`` (N,) is in m/s. Spheres are drawn at their periodic images in the cell. Those
        glued to the plane are grey.
        """
        wrapped = position.copy()
        wrapped[:, :2] %= self.cell
        is_shown = (wrapped[:, :2] < self.shown_size).all(axis=1)
        colour = np.where(self.is_glued[:, None], _GLUED_COLOUR, COLOURS(self.norm(speed))[:, :3])
        return picture(
            self.view,
            self.frame,
            self.pixel,
            wrapped[is_shown],
            self.radius[is_shown],
            colour[is_shown],
            floor=self.floor,
        )

    def show(self, axes: Axes, image: np.ndarray) -> Any:
        """Show a picture in units of σ, with arrows of flow and gravity, scale bar and colour bar.

        Returns the image in the axes; animations replace its data by the next picture.
        """
        left, right, bottom, top = np.array(self.frame) / self.diameter
        shown = axes.imshow(image, extent=(left, right, bottom, top), interpolation="bilinear")
        axes.set(xticks=[], yticks=[], anchor="W")
        axes.spines[:].set_visible(False)
        self._draw_arrows(axes)
        bar = axes.figure.colorbar(
            ScalarMappable(self.norm, COLOURS), ax=axes, shrink=0.55, aspect=22, pad=0.02
        )
        bar.set_label("velocity of spheres u (m/s)")
        bar.outline.set_visible(False)
        return shown

    def _draw_arrows(self, axes: Axes) -> None:
        """Draw arrows of the flow (in front of the plane) and of gravity, and a bar of 5 σ."""
        left, right, bottom, top = np.array(self.frame) / self.diameter
        length = 0.17 * max(right - left, top - bottom)
        start = self.floor[0] + self.diameter * np.array([1.0, -1.3])
        path = [(*start, 0.0), (start[0] + length * self.diameter, start[1], 0.0)]
        (x0, y0, _), (x1, y1, _) = project(self.view, np.array(path)) / self.diameter
        axes.annotate("", (x1, y1), (x0, y0), arrowprops=_ARROW, annotation_clip=False)
        axes.text(x0, y0 - 0.02 * length, "flow ", ha="right", va="top", **_TEXT)
        aside = right - 0.3 * length
        axes.annotate("", (aside, top - length), (aside, top), arrowprops=_ARROW)
        axes.text(aside, top - 0.5 * length, " g", ha="left", va="center", **_TEXT)
        low = bottom - 0.1 * length
        axes.plot([right - 5, right], [low, low], color=DARK, linewidth=2, solid_capstyle="butt")
        axes.text(right - 2.5, low - 0.1 * length, "5 σ", ha="center", va="top", **_TEXT)
        axes.set_xlim(min(left, x0 - 0.8 * length), right)
        axes.set_ylim(low - 0.7 * length, top)
