"""The particles of a run from the side: as they are at its end, and as they move."""

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

from sim.dataset.run_file import RunFile
from sim.figures.render import settle
from sim.figures.style import SETTINGS
from sim.figures.units import headed
from sim.parameters import Parameters

#: Inches of a picture's width, and at most of its height and of a diameter in it.
WIDTH, TALLEST, LARGEST = 7.4, 6.0, 0.5

#: Particles from which on a picture holds pixels, not outlines.
MANY = 1500

#: Pictures of an animation at most, dots per inch, and milliseconds of each.
FRAMES, DPI, DURATION = 60, 100, 100

#: The velocities between which colours differ, as shares of the particles: a single fast one would
#: make all others one colour.
_SHOWN = (0.02, 0.98)

#: The line at z = 0.
_BELOW = {"chute": "plane", "belt": "average position of the belt", "conveyor": "moving plane"}


@dataclass(frozen=True)
class Seen:
    """Particles of a replicate in some frames: ``place`` (F, N, D) and ``speed`` along x (F, N) in
    diameters and m/s, ``size`` (N,) in diameters, ``wide`` the period along x."""

    place: np.ndarray
    speed: np.ndarray
    size: np.ndarray
    wide: float
    system: str

    def __iter__(self) -> Iterator[EllipseCollection]:
        """Yield the particles of each frame, those at the front last."""
        span = np.quantile(self.speed, _SHOWN)
        for place, speed in zip(self.place, self.speed, strict=True):
            x = np.mod(place[:, 0], self.wide)
            # Those across the periodic sides are seen at both.
            over = [x < self.size / 2, x > self.wide - self.size / 2]
            every = np.concatenate([np.arange(len(x)), *map(np.flatnonzero, over)])
            shift = np.repeat(
                [0.0, self.wide, -self.wide], [len(x), *(side.sum() for side in over)]
            )
            front = np.argsort(-place[every, 1], kind="stable") if place.shape[1] == 3 else ...
            order, shift = every[front], shift[front]
            size = self.size[order]
            yield EllipseCollection(
                size,
                size,
                np.zeros_like(size),
                units="xy",
                offsets=np.column_stack([x[order] + shift, place[order, -1]]),
                array=speed[order],
                clim=span,
                cmap="cividis",
                edgecolors="black",
                linewidths=0.3,
                rasterized=len(size) > MANY,
            )


def picture(run: RunFile, parameters: Parameters) -> Figure | None:
    """Return the first completed replicate at its end, nothing where there is none."""
    seen = _seen(run, parameters, "position", "particle_velocity", np.s_[-1:])
    if seen is None:
        return None
    figure, axes = _axes(seen)
    _show(axes, next(iter(seen)))
    return figure


def animation(run: RunFile, parameters: Parameters) -> bytes | None:
    """Return the trajectory of the first completed replicate as an endless WebP.

    Nothing where it has none.
    """
    count = len(run["trajectory_time"]) if "trajectory_time" in run else 0
    frames = np.unique(np.linspace(0, count - 1, min(count, FRAMES)).astype(int))
    seen = _seen(run, parameters, "trajectory_position", "trajectory_velocity", frames)
    if seen is None:
        return None
    with mpl.rc_context(SETTINGS):
        return _as_webp(seen)


def _as_webp(seen: Seen) -> bytes:
    figure, axes = _axes(seen)
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    images: list[Image.Image] = []
    for held in seen:
        _show(axes, held)
        if not images:
            settle(figure)
            figure.set_layout_engine("none")
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()))
        held.remove()
    file = BytesIO()
    options = {"save_all": True, "loop": 0, "duration": DURATION, "quality": 75}
    images[0].save(file, format="WebP", append_images=images[1:], **options)
    return file.getvalue()


def _seen(
    run: RunFile, parameters: Parameters, place: str, velocity: str, frames: slice | np.ndarray
) -> Seen | None:
    completed = np.flatnonzero(np.asarray(run["status"]) == "completed")
    if not completed.size or place not in run:
        return None
    number = completed[0]
    places = run.part(place, (number, frames))
    known = np.isfinite(places).all(axis=(1, 2))
    if not known.any():
        return None
    return Seen(
        places[known] / parameters.diameter,
        run.part(velocity, (number, frames))[known][..., 0],
        2 * run["radius"][number] / parameters.diameter,
        parameters.period / parameters.diameter,
        parameters.system,
    )


def _axes(seen: Seen) -> tuple[Figure, Axes]:
    """Return a figure with axes that show all frames to scale."""
    heights = seen.place[..., -1]
    low = min(0.0, float((heights - seen.size / 2).min())) - 0.3
    high = float((heights + seen.size / 2).max()) + 0.3
    scale = min((WIDTH - 2) / seen.wide, TALLEST / (high - low), LARGEST)
    shape = max(4.0, seen.wide * scale + 2), max(2.0, (high - low) * scale + 0.7)
    figure = Figure(figsize=shape, layout="compressed")
    axes = figure.subplots()
    axes.set(xlim=(0, seen.wide), ylim=(low, high), aspect="equal")
    axes.set_xlabel(headed("x", "diameters") + f"; the line is the {_BELOW[seen.system]}")
    axes.set_ylabel(headed("z", "diameters"))
    axes.grid(visible=False)
    axes.axhline(0, color="black", linewidth=1.3)
    return figure, axes


def _show(axes: Axes, held: EllipseCollection) -> None:
    """Put the particles of a frame into axes, and what their colours mean beside the first."""
    held.set_offset_transform(axes.transData)
    axes.add_collection(held)
    if len(axes.figure.axes) == 1:
        label = headed("velocity along x", "m/s")
        axes.figure.colorbar(held, ax=axes, label=label, extend="both", shrink=0.9)
