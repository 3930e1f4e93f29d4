"""The particles of one run as an animation."""

from dataclasses import dataclass
from io import BytesIO

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from PIL import Image

from sim.figures.data import label_with_unit
from sim.figures.render import settle
from sim.figures.spheres import COLOURS, across_sides, draw_particles
from sim.figures.style import SETTINGS

#: Most inches of a picture's width, of its height, and of a diameter in it.
_MOST_WIDTH, _MOST_HEIGHT, _MOST_DIAMETER = 7.4, 6.0, 0.5

#: Dots per inch of an animation, and milliseconds per frame.
_DPI, DURATION = 100, 100

#: Quantiles of the velocities between which colours differ: a single fast particle would otherwise
#: give all others one colour.
_COLOUR_QUANTILES = (0.02, 0.98)


@dataclass(frozen=True)
class ParticleFrames:
    """Particles of a replicate in some frames.

    ``position`` (F, N, 3) and ``size`` (N,) are in diameters, ``speed`` (F, N) along x is in m/s,
    and ``period`` is the period along x in diameters.
    """

    position: np.ndarray
    speed: np.ndarray
    size: np.ndarray
    period: float

    def draw(self, axes: Axes, frame: int, norm: Normalize) -> EllipseCollection:
        """Draw the particles of a frame; their colours show their velocities."""
        position = self.position[frame]
        index, x = across_sides(position[:, 0], self.size, self.period)
        place, colour = np.column_stack([x, position[index, -1]]), COLOURS(norm(self.speed[frame]))
        return draw_particles(
            axes,
            place,
            self.size[index],
            colour[index],
            -position[index, 1],
            edgecolors="black",
            linewidths=0.3,
        )


def animation(frames: ParticleFrames) -> bytes:
    """Return an endless WebP of the particles, coloured by their velocity along x."""
    with mpl.rc_context(SETTINGS):
        return _as_webp(frames)


def _as_webp(frames: ParticleFrames) -> bytes:
    figure, axes = _axes(frames)
    figure.set_dpi(_DPI)
    norm = Normalize(*np.quantile(frames.speed, _COLOUR_QUANTILES))
    label = label_with_unit("velocity along x", "m/s")
    shades = ScalarMappable(norm, COLOURS)
    figure.colorbar(shades, ax=axes, label=label, extend="both", shrink=0.9)
    settle(figure)
    figure.set_layout_engine("none")
    canvas = FigureCanvasAgg(figure)
    images: list[Image.Image] = []
    for frame in range(len(frames.position)):
        particles = frames.draw(axes, frame, norm)
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()))
        particles.remove()
    file = BytesIO()
    options = {"save_all": True, "loop": 0, "duration": DURATION, "quality": 75}
    images[0].save(file, format="WebP", append_images=images[1:], **options)
    return file.getvalue()


def _axes(frames: ParticleFrames) -> tuple[Figure, Axes]:
    """Return a figure with axes that show all frames to scale."""
    heights = frames.position[..., -1]
    low = min(0.0, float((heights - frames.size / 2).min())) - 0.3
    high = float((heights + frames.size / 2).max()) + 0.3
    scale = min((_MOST_WIDTH - 2) / frames.period, _MOST_HEIGHT / (high - low), _MOST_DIAMETER)
    shape = max(4.0, frames.period * scale + 2), max(2.0, (high - low) * scale + 0.7)
    figure = Figure(figsize=shape, layout="compressed")
    axes = figure.subplots()
    axes.set(xlim=(0, frames.period), ylim=(low, high), aspect="equal")
    axes.set_xlabel(label_with_unit("x", "diameters"))
    axes.set_ylabel(label_with_unit("z", "diameters"))
    axes.grid(visible=False)
    axes.axhline(0, color="black", linewidth=1.3)
    return figure, axes
