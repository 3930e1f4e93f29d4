"""The particles of one run as an animation."""

from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from PIL import Image

from sim.figures.data import label_with_unit
from sim.figures.render import settle
from sim.figures.style import SETTINGS

#: Most inches of a picture's width, of its height, and of a diameter in it.
_MOST_WIDTH, _MOST_HEIGHT, _MOST_DIAMETER = 7.4, 6.0, 0.5

#: Number of particles above which they are drawn as pixels instead of outlines.
RASTER_FROM = 1500

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

    def __iter__(self) -> Iterator[EllipseCollection]:
        """Yield the particles of each frame as circles, those at the front last."""
        span = np.quantile(self.speed, _COLOUR_QUANTILES)
        for position, speed in zip(self.position, self.speed, strict=True):
            x = np.mod(position[:, 0], self.period)
            # Particles across a periodic side are drawn at both sides.
            is_across = [x < self.size / 2, x > self.period - self.size / 2]
            particles = np.concatenate([np.arange(len(x)), *map(np.flatnonzero, is_across)])
            shift = np.repeat(
                [0.0, self.period, -self.period], [len(x), *(side.sum() for side in is_across)]
            )
            front = np.argsort(-position[particles, 1], kind="stable")
            order, shift = particles[front], shift[front]
            size = self.size[order]
            yield EllipseCollection(
                size,
                size,
                np.zeros_like(size),
                units="xy",
                offsets=np.column_stack([x[order] + shift, position[order, -1]]),
                array=speed[order],
                clim=span,
                cmap="cividis",
                edgecolors="black",
                linewidths=0.3,
                rasterized=len(size) > RASTER_FROM,
            )


def animation(frames: ParticleFrames) -> bytes:
    """Return an endless WebP of the particles, coloured by their velocity along x."""
    with mpl.rc_context(SETTINGS):
        return _as_webp(frames)


def _as_webp(frames: ParticleFrames) -> bytes:
    figure, axes = _axes(frames)
    figure.set_dpi(_DPI)
    canvas = FigureCanvasAgg(figure)
    images: list[Image.Image] = []
    for particles in frames:
        _show(axes, particles)
        if not images:
            settle(figure)
            figure.set_layout_engine("none")
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


def _show(axes: Axes, particles: EllipseCollection) -> None:
    """Draw the particles of a frame into axes, and add a colour bar the first time."""
    particles.set_offset_transform(axes.transData)
    axes.add_collection(particles)
    if len(axes.figure.axes) == 1:
        label = label_with_unit("velocity along x", "m/s")
        axes.figure.colorbar(particles, ax=axes, label=label, extend="both", shrink=0.9)
