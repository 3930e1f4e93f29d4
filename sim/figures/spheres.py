"""Pictures of shaded spheres, seen without perspective."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from sim.study.plot_kinds import LARGEST_PORTION

#: Share of ambient light, and the direction to the light source: right, up, toward the viewer.
AMBIENT = 0.45
LIGHT = np.array([-0.45, 0.70, 0.55]) / np.linalg.norm([-0.45, 0.70, 0.55])

#: Spheres darken towards their outline, where the surface normal along the view is below this.
RIM = 0.35

FLOOR_COLOUR = np.array([0.86, 0.84, 0.80])

#: Brightness in a shadow, and the depth behind a lit surface, in radii, up to which there is none.
SHADOW, BIAS = 0.72, 0.25

#: Pixels are drawn this many times finer along each side; their mean has smooth edges.
FINENESS = 2


class View(NamedTuple):
    """Unit vectors (3,) to the right and up in the picture, and from the scene to the viewer."""

    right: np.ndarray
    up: np.ndarray
    toward: np.ndarray


class Frame(NamedTuple):
    """The shown part of the picture's plane, m."""

    left: float
    right: float
    bottom: float
    top: float


def view_from(azimuth: float, elevation: float, slope: float = 0.0) -> View:
    """Return the view of a viewer who looks along y, with x to the right and z up.

    Parameters
    ----------
    azimuth, elevation : float
        Angle of the viewer round towards negative x, and angle above the horizontal, degrees.
    slope : float
        Angle by which x points below the horizontal of the picture, degrees.
    """
    a, e, s = np.radians([azimuth, elevation, slope])
    right = np.array([np.cos(a), -np.sin(a), 0.0])
    toward = np.array([-np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
    level = np.stack([right, np.cross(toward, right), toward])
    inclined = np.array([[np.cos(s), 0, np.sin(s)], [0, 1, 0], [-np.sin(s), 0, np.cos(s)]])
    return View(*(level @ inclined))


def project(view: View, points: np.ndarray) -> np.ndarray:
    """Return coordinates of points (..., 3) in a view: to the right, up, and toward the viewer."""
    return points @ np.stack(view, axis=-1)


def frame_around(view: View, points: np.ndarray, margin: float) -> Frame:
    """Return the smallest frame that shows all points (..., 3) with a margin (m) around them."""
    flat = project(view, points).reshape(-1, 3)[:, :2]
    (left, bottom), (right, top) = flat.min(axis=0) - margin, flat.max(axis=0) + margin
    return Frame(left, right, bottom, top)


def picture(
    view: View,
    frame: Frame,
    pixel: float,
    position: np.ndarray,
    radius: np.ndarray,
    colour: np.ndarray,
    *,
    floor: np.ndarray | None = None,
) -> np.ndarray:
    """Return a picture of shaded spheres, the nearest in front.

    Parameters
    ----------
    view : View
        Direction of the view.
    frame : Frame
        Shown part of the picture's plane.
    pixel : float
        Side of a pixel, m.
    position, radius, colour : numpy.ndarray
        Centres (N, 3) and radii (N,), m, and colours (N, 3), red, green and blue from 0 to 1.
    floor : numpy.ndarray, optional
        Corners of a floor at z = 0: least and largest x and y (2, 2), m.

    Returns
    -------
    numpy.ndarray
        (H, W, 4) from the top down, red, green, blue and opacity as bytes.
    """
    height, width = _size(frame, pixel)
    flat = _pixels(frame, height * FINENESS, width * FINENESS)
    centre = project(view, position)
    owner, depth = _nearest(flat, centre, radius)
    rgb = _shade(flat, centre, radius, colour, owner)
    if floor is not None:
        ground = _depth_of_floor(view, flat, floor)
        rgb[ground > depth] = FLOOR_COLOUR
        depth = np.maximum(depth, ground)
    is_covered = np.isfinite(depth)
    rgb[is_covered] *= _shadow_brightness(
        np.column_stack([flat[is_covered], depth[is_covered]]), centre, radius, pixel
    )[:, None]
    # Colours are weighted by opacity, so that the background does not darken edges.
    layers = np.concatenate([rgb * is_covered[..., None], is_covered[..., None]], axis=-1)
    mean = layers.reshape(height, FINENESS, width, FINENESS, 4).mean(axis=(1, 3))
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-9)
    return np.round(255 * np.clip(mean, 0, 1)).astype(np.uint8)


def _size(frame: Frame, pixel: float) -> tuple[int, int]:
    """Return the height and the width of a picture in pixels."""
    size = frame.top - frame.bottom, frame.right - frame.left
    return max(1, round(size[0] / pixel)), max(1, round(size[1] / pixel))


def _pixels(frame: Frame, height: int, width: int) -> np.ndarray:
    """Return the positions of the centres of the pixels (H, W, 2), from the top down."""
    x = frame.left + (np.arange(width) + 0.5) * (frame.right - frame.left) / width
    y = frame.top - (np.arange(height) + 0.5) * (frame.top - frame.bottom) / height
    return np.stack(np.meshgrid(x, y), axis=-1)


def _nearest(
    flat: np.ndarray, centre: np.ndarray, radius: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sphere that each pixel shows (H, W), -1 for none, and its depth (H, W), m.

    The depth grows toward the viewer and is minus infinity without a sphere.
    """
    owner = np.full(flat.shape[:2], -1)
    depth = np.full(owner.shape, -np.inf)
    x, y = flat[0, :, 0], flat[:, 0, 1]
    for i, ((right, up, toward), r) in enumerate(zip(centre, radius, strict=True)):
        columns = slice(*np.searchsorted(x, (right - r, right + r)))
        rows = slice(*np.searchsorted(-y, (-up - r, -up + r)))
        squared = r * r - (x[columns] - right) ** 2 - (y[rows, None] - up) ** 2
        near = np.where(squared > 0, toward + np.sqrt(np.maximum(squared, 0)), -np.inf)
        nearer = near > depth[rows, columns]
        depth[rows, columns][nearer] = near[nearer]
        owner[rows, columns][nearer] = i
    return owner, depth


def _shade(
    flat: np.ndarray,
    centre: np.ndarray,
    radius: np.ndarray,
    colour: np.ndarray,
    owner: np.ndarray,
) -> np.ndarray:
    """Return the colour of each pixel (H, W, 3) by Lambert's law, darker at outlines."""
    rgb = np.zeros((*owner.shape, 3))
    is_covered = owner >= 0
    spheres = owner[is_covered]
    aside = (flat[is_covered] - centre[spheres, :2]) / radius[spheres, None]
    toward = np.sqrt(np.clip(1 - (aside**2).sum(axis=1), 0, 1))
    facing = np.column_stack([aside, toward]) @ LIGHT
    bright = AMBIENT + (1 - AMBIENT) * np.clip(facing, 0, 1)
    bright *= np.clip(0.4 + 0.6 * toward / RIM, 0, 1)
    rgb[is_covered] = colour[spheres] * bright[:, None]
    return rgb


def _depth_of_floor(view: View, flat: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Return the depth (m) of the floor in each pixel, minus infinity outside it."""
    plane = flat @ np.stack([view.right, view.up])
    near = -plane[..., 2] / view.toward[2]
    on_floor = (plane + near[..., None] * view.toward)[..., :2]
    inside = ((on_floor > floor[0]) & (on_floor < floor[1])).all(axis=-1)
    return np.where(inside, near, -np.inf)


def _shadow_brightness(
    points: np.ndarray, centre: np.ndarray, radius: np.ndarray, pixel: float
) -> np.ndarray:
    """Return the brightness (M,) of points (M, 3) under shadows, in coordinates of the view.

    A point is in a shadow where a sphere is nearer to the light. This follows from a depth map of
    the spheres as the light sees them.
    """
    if not len(radius):
        return np.ones(len(points))
    right = np.cross([0.0, 1.0, 0.0], LIGHT)
    right /= np.linalg.norm(right)
    lamp = View(right, np.cross(LIGHT, right), LIGHT)
    projected = project(lamp, points)
    frame = frame_around(lamp, centre, 2 * radius.max())
    flat = _pixels(frame, *_size(frame, pixel / FINENESS))
    _, depth = _nearest(flat, project(lamp, centre), radius)
    height, width = depth.shape
    column = (projected[:, 0] - frame.left) / (frame.right - frame.left) * width
    row = (frame.top - projected[:, 1]) / (frame.top - frame.bottom) * height
    # No sphere casts a shadow at the edge of the frame or beyond, so indices may be clipped.
    row, column = (
        np.clip(index, 0, size - 1).astype(int) for index, size in ((row, height), (column, width))
    )
    return np.where(depth[row, column] > projected[:, 2] + BIAS * radius.max(), SHADOW, 1.0)


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
