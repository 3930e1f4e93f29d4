"""Pictures of one run: its mean velocity over time, its profiles, its particles; an animation."""

from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO, StringIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from PIL import Image

from sim.engine.stored_run import RunFile
from sim.figures.data import label_with_unit
from sim.figures.render import settle
from sim.figures.style import COLOURS, LEVEL, SETTINGS
from sim.figures.time_series import average_successive
from sim.parameters import Parameters
from sim.parameters.variables import variables_of
from sim.study.plot_kinds import SHARE

#: Inches of a picture's width and height.
SIZE = (7.4, 2.8)

#: Most inches of a picture's width, of its height, and of a diameter in it.
_MOST_WIDTH, _MOST_HEIGHT, _MOST_DIAMETER = 7.4, 6.0, 0.5

#: Number of particles above which they are drawn as pixels instead of outlines.
RASTER_FROM = 1500

#: Most frames of an animation, dots per inch, and milliseconds per frame.
FRAMES, _DPI, DURATION = 60, 100, 100

#: Quantiles of the velocities between which colours differ: a single fast particle would otherwise
#: give all others one colour.
_COLOUR_QUANTILES = (0.02, 0.98)

#: Meaning of the line at z = 0, by system.
_BASE_LINE = {"chute": "plane", "belt": "average position of the belt", "conveyor": "moving plane"}


def _look(number: int) -> dict[str, Any]:
    """Return the style of the lines of a replicate."""
    return {"color": COLOURS[number % len(COLOURS)], "linewidth": 0.9, "alpha": 0.8}


def pictures(run: RunFile, parameters: Parameters) -> dict[str, str]:
    """Return pictures of a run as SVG texts, by title; pictures without data are left out.

    Parameters
    ----------
    run : RunFile
        The run.
    parameters : Parameters
        Its point.
    """
    completed = np.flatnonzero(np.asarray(run["status"]) == "completed")
    with mpl.rc_context(SETTINGS):
        drawn = {
            "Mean velocity of all particles": _series(run),
            "Profiles over the height": _profiles(run, parameters, completed),
            "Particles of the first completed replicate at the end": _particles(run, parameters),
        }
        return {title: _as_svg(figure) for title, figure in drawn.items() if figure}


def _as_svg(figure: Figure) -> str:
    settle(figure)
    text = StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


def _series(run: RunFile) -> Figure | None:
    """Draw the velocity of each replicate, and a dotted line where averaging begins.

    None without any finite velocity.
    """
    values, time = np.asarray(run["mean_velocity"]), np.asarray(run["time"])
    if not np.isfinite(values).any():
        return None
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    for number, velocity in enumerate(values):
        is_known = np.isfinite(velocity)
        label = f"replicate {number}"
        axes.plot(
            average_successive(time[is_known]),
            average_successive(velocity[is_known]),
            label=label,
            **_look(number),
        )
    starts = np.asarray(run["average_start"], float)
    if np.isfinite(starts).any():
        axes.axvline(float(np.nanmean(starts)), **LEVEL)
    axes.set_xlabel(label_with_unit("time since the start", "s"))
    axes.set_ylabel(label_with_unit("mean velocity", "m/s"))
    if 1 < len(values) <= len(COLOURS):
        figure.legend(loc="outside upper center", ncols=4)
    return figure


def _profiles(run: RunFile, parameters: Parameters, completed: np.ndarray) -> Figure | None:
    """Draw the profiles of all completed replicates, up to the height below which `SHARE` is.

    None without a completed replicate or without profiles.
    """
    names = "velocity_profile", "packing_profile"
    if not completed.size or not all(name in run for name in names):
        return None
    height = np.asarray(run["height"]) / parameters.diameter
    cumulative = np.cumsum(np.nanmean(np.asarray(run["packing_profile"])[completed], axis=0))
    top = int(np.searchsorted(cumulative, SHARE * cumulative[-1])) + 1
    figure = Figure(figsize=SIZE, layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True)
    for axes, name in zip(panels, names, strict=True):
        for number in completed:
            axes.plot(np.asarray(run[name])[number][:top], height[:top], **_look(number))
        row = variables_of("profile")[name]
        axes.set_xlabel(label_with_unit(row.meaning, "m/s" if row.unit == "m s-1" else ""))
    panels[0].set_ylabel(label_with_unit("height", "diameters"))
    return figure


@dataclass(frozen=True)
class ParticleFrames:
    """Particles of a replicate in some frames.

    ``position`` (F, N, D) and ``size`` (N,) are in diameters, ``speed`` (F, N) along x is in m/s,
    and ``period`` is the period along x in diameters.
    """

    position: np.ndarray
    speed: np.ndarray
    size: np.ndarray
    period: float
    system: str

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
            front = (
                np.argsort(-position[particles, 1], kind="stable")
                if position.shape[1] == 3
                else ...
            )
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


def _particles(run: RunFile, parameters: Parameters) -> Figure | None:
    """Return a picture of the first completed replicate at its end; None without one."""
    frames = _read_frames(run, parameters, "position", "particle_velocity", np.s_[-1:])
    if frames is None:
        return None
    figure, axes = _axes(frames)
    _show(axes, next(iter(frames)))
    return figure


def animation(run: RunFile, parameters: Parameters) -> bytes | None:
    """Return the trajectory of the first completed replicate as an endless WebP.

    None where it has no trajectory.
    """
    count = len(run["trajectory_time"]) if "trajectory_time" in run else 0
    frames = np.unique(np.linspace(0, count - 1, min(count, FRAMES)).astype(int))
    particle_frames = _read_frames(
        run, parameters, "trajectory_position", "trajectory_velocity", frames
    )
    if particle_frames is None:
        return None
    with mpl.rc_context(SETTINGS):
        return _as_webp(particle_frames)


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


def _read_frames(
    run: RunFile, parameters: Parameters, position: str, velocity: str, frames: slice | np.ndarray
) -> ParticleFrames | None:
    completed = np.flatnonzero(np.asarray(run["status"]) == "completed")
    if not completed.size or position not in run:
        return None
    number = completed[0]
    positions = run.read_slice(position, (number, frames))
    is_known = np.isfinite(positions).all(axis=(1, 2))
    if not is_known.any():
        return None
    return ParticleFrames(
        positions[is_known] / parameters.diameter,
        run.read_slice(velocity, (number, frames))[is_known][..., 0],
        2 * run["radius"][number] / parameters.diameter,
        parameters.period / parameters.diameter,
        parameters.system,
    )


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
    axes.set_xlabel(
        label_with_unit("x", "diameters") + f"; the line is the {_BASE_LINE[frames.system]}"
    )
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
