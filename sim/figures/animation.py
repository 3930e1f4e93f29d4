"""Animations: spheres on an inclined plane, beads over one cycle, and the particles of one run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from PIL import Image

from sim.figures.beads import draw_obstacle
from sim.figures.caption import velocity_text
from sim.figures.data import FigureData, point_table
from sim.figures.pictures import Animation, drawn_frames
from sim.figures.plot import message_figure
from sim.figures.spheres import COLOURS, DARK, Scene, across_sides, draw_particles
from sim.figures.style import SETTINGS, SHORT_DASH
from sim.study.plottable import TALLEST

#: Frames of a chute flow, and how far the fastest spheres go from one to the next, in diameters.
FRAMES, STRIDE = 24, 0.35

#: A frame shows one state of so many of the path, for so long (ms).
EVERY, DURATION = 2, 130

#: Beads whose paths are drawn, and distance of the marks on the belt, in mean diameters.
_FOLLOWED, _MARKS = 8, 2.0

#: Most inches of a picture's width, of its height, and of a diameter in it.
_MOST_WIDTH, _MOST_HEIGHT, _MOST_DIAMETER = 7.4, 6.0, 0.85

#: A picture goes up to so many times the height below which this share of the particles is.
_CLEARANCE, _MOST = 1.5, 0.95

#: Resolution of the pictures of a run, dots per inch.
_DPI = 100

#: Quantiles of the velocities between which colours differ: a single fast particle would otherwise
#: give all others one colour.
_COLOUR_QUANTILES = (0.02, 0.98)


def select(data: FigureData) -> FigureData:
    """Return the data with a single point: the first with particles, published protocol first.

    With ``point: "slowest"``, slower flows precede faster ones.
    """
    rows = data.rows
    if data.spec.point == "slowest":
        rows = rows.sort_values(["completed", "velocity"], ascending=[False, True])
    rows = rows.sort_values("protocol", ascending=False, kind="stable")
    with_particles = rows[rows["point"].isin(list(data.results.states))]
    return replace(data, rows=(with_particles if len(with_particles) else rows)[:1])


def draw(data: FigureData) -> Animation:
    """Animate the flow of the one point."""
    (row,) = data.rows.to_dict("records")
    state = data.results.states.get(row["point"])
    if state is None or "path" not in state:
        return Animation(message_figure("no motion stored"), 1, lambda number: None)
    return (_animate_belt if data.spec.system == "belt" else _animate_chute)(row, state)


#: The data behind it are those of its point.
table = point_table


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of the flow."""
    (row,) = data.rows.to_dict("records")
    slow = "" if data.spec.system == "belt" else "After the averaging window, in slow motion. "
    text = f"{slow}Mean velocity of the window {velocity_text(row)} ({row['regime']})."
    return [text] if row["completed"] else []


def _animate_chute(row: Mapping[str, Any], state: xr.Dataset) -> Animation:
    time, position, speed = motion(state, row["diameter"])
    unit = np.sqrt(row["diameter"] / row["gravity"])
    scene = Scene(row, state, position[..., 2], speed)
    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1))
    scene.prepare(left)
    spheres = [scene.draw(left, position[0], speed[0])]
    heights = position[..., 2] / row["diameter"]
    (dots,) = right.plot([], [], "o", markersize=2.2, color=COLOURS(0.25), alpha=0.7)
    low, high = scene.norm.vmin or 0.0, scene.norm.vmax or 0.0
    margin = 0.1 * (high - low)
    right.set(xlim=(min(0.0, low - margin), high + margin), ylim=(0, heights.max() + 0.5))
    right.set(xlabel="velocity u (m/s)", ylabel="height z/σ")
    clock = left.set_title(" ", loc="left", fontsize=8.5)

    def show(number: int) -> None:
        spheres.pop().remove()
        spheres.append(scene.draw(left, position[number], speed[number]))
        dots.set_data(speed[number], heights[number])
        mean = round(speed[number].mean(), 3) + 0.0
        clock.set_text(f"t = {time[number] / unit:5.2f} √(σ/g), mean u = {mean:.3f} m/s")

    return Animation(figure, FRAMES, show)


def motion(state: xr.Dataset, diameter: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times (F,), s, centres (F, N, 3), m, and velocities down the slope (F, N), m/s.

    They are interpolated between the states of the path, over as much of it as lets the fastest
    spheres go by no more than `STRIDE` from frame to frame.
    """
    instants, path = state["path_time"].values.astype(float), state["path"].astype(float)
    speed = np.gradient(path.values[..., 0], instants, axis=0)
    fastest = max(float(np.percentile(speed, 99)), 1e-9)
    time = np.linspace(0, min(instants[-1], (FRAMES - 1) * STRIDE * diameter / fastest), FRAMES)
    both = xr.Dataset({"path": path, "speed": (path.dims[:2], speed)})
    shown = both.assign_coords(path_time=instants).interp(path_time=time)
    return time, shown["path"].values, shown["speed"].values


@dataclass(frozen=True)
class ParticleFrames:
    """Particles of a replicate in some frames, seen from the side.

    ``position`` (F, N, 2 or 3) and ``size`` (N,) are in diameters, ``speed`` (F, N) along x is in
    m/s, and ``period`` is the period along x in diameters.
    """

    position: np.ndarray
    speed: np.ndarray
    size: np.ndarray
    period: float

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest place of a particle, diameters."""
        heights, radius = self.position[..., -1], self.size / 2
        return float((heights - radius).min()), float((heights + radius).max())

    @property
    def height_of_most(self) -> float:
        """Height of a picture, without single particles high above the others."""
        top = np.sort(self.position[..., -1] + self.size / 2, axis=1)
        return float(_CLEARANCE * top[:, int(_MOST * (top.shape[1] - 1))].max())

    @property
    def norm(self) -> Normalize:
        """From velocities to the range of the colours."""
        return Normalize(*np.quantile(self.speed, _COLOUR_QUANTILES))

    def prepare(self, low: float, high: float) -> tuple[Figure, Axes]:
        """Return a figure with axes to scale between two heights, and with a colour bar."""
        scale = min((_MOST_WIDTH - 2) / self.period, _MOST_HEIGHT / (high - low), _MOST_DIAMETER)
        shape = max(4.0, self.period * scale + 2), max(2.0, (high - low) * scale + 0.7)
        figure = Figure(figsize=shape, layout="compressed")
        axes = figure.subplots()
        axes.set(xlim=(0, self.period), ylim=(low, high), aspect="equal")
        axes.grid(visible=False)
        shades = ScalarMappable(self.norm, COLOURS)
        look: dict[str, Any] = {"extend": "both", "shrink": 0.9}
        figure.colorbar(shades, ax=axes, label="velocity along x (m/s)", **look)
        return figure, axes

    def draw(self, axes: Axes, frame: int) -> EllipseCollection:
        """Draw the particles of a frame; their colours show their velocities."""
        position = self.position[frame]
        index, x = across_sides(position[:, 0], self.size, self.period)
        place, colour = np.column_stack([x, position[index, -1]]), self.norm(self.speed[frame])
        look: dict[str, Any] = {"edgecolors": DARK, "linewidths": 0.3, "zorder": 2}
        # Those with the least y are nearest.
        depth = -position[index, 1] if position.shape[1] == 3 else None
        return draw_particles(axes, place, self.size[index], COLOURS(colour[index]), depth, **look)


def _animate_belt(row: Mapping[str, Any], state: xr.Dataset) -> Animation:
    position, time = state["path"].values.astype(float), state["path_time"].values.astype(float)
    speed, unit = np.gradient(position[..., 0], time, axis=0), row["diameter"]
    sizes = 2 * state["radius"].values / unit
    beads = ParticleFrames(position / unit, speed, sizes, float(row["width"]))
    low, high = -row["amplitude"] - 1.0, min(beads.ends[1] + 0.5, TALLEST)
    figure, axes = beads.prepare(low, high)
    axes.set(xlabel="along the belt x/⟨d⟩", ylabel="height z/⟨d⟩")
    for level in (-row["amplitude"], row["amplitude"]):
        axes.axhline(level, color="#888888", linestyle=SHORT_DASH, linewidth=0.8, zorder=1)
    draw_obstacle(axes, row)
    drawn = [beads.draw(axes, 0)]
    (line,) = axes.plot([], [], "|-", color=DARK, linewidth=2.2, markersize=9, zorder=3)
    first = beads.position[0, :, 0]
    followed = np.argsort(first)[:: max(1, len(first) // _FOLLOWED)]
    # Each path begins within the cell.
    paths = beads.position[:, followed] - [[beads.period, 0]] * (
        first[followed, None] // beads.period
    )
    look: dict[str, Any] = {"color": "#d55e00", "linewidth": 0.9, "zorder": 4}
    trails = [axes.plot([], [], **look)[0] for _ in followed]
    clock = axes.set_title(" ", loc="left", fontsize=8.5)

    def show(frame: int) -> None:
        number = EVERY * frame
        for trail, path in zip(trails, paths[: number + 1].transpose(1, 2, 0), strict=True):
            trail.set_data(*path)
        drawn.pop().remove()
        drawn.append(beads.draw(axes, number))
        places, level = belt_marks(row, time[number])
        line.set_data(places, np.full(len(places), level))
        cycles = time[number] * row["frequency"]
        clock.set_text(f"f = {row['frequency']:g} Hz, t = {cycles:.2f} cycles")

    return Animation(figure, (len(time) - 1) // EVERY, show, DURATION)


def belt_marks(row: Mapping[str, Any], time: float) -> tuple[np.ndarray, float]:
    """Return where marks on the belt of a point are (M,), and its height, at a time in s."""
    phase = np.sin(2 * np.pi * row["frequency"] * time + np.radians(row["phase"]))
    slope = np.tan(np.radians(row["vibration_angle"]))
    marks = np.arange(-2 * _MARKS, row["width"] + 2 * _MARKS, _MARKS)
    return marks + row["amplitude"] / slope * phase, row["amplitude"] * phase


def run_frames(particles: ParticleFrames, times: Sequence[float]) -> list[Image.Image]:
    """Return pictures of the particles at some times (s), coloured by their velocity along x."""
    with mpl.rc_context(SETTINGS):
        low, top = particles.ends
        high = particles.height_of_most
        figure, axes = particles.prepare(min(0.0, low) - 0.3, min(top, high) + 0.3)
        axes.set(xlabel="x (diameters)", ylabel="z (diameters)")
        flying = f"; single particles fly up to {top:.0f} diameters" if top > high else ""
        clock = axes.set_title(" ", loc="left", fontsize=8.5)
        axes.axhline(0, color="black", linewidth=1.3)
        drawn = [particles.draw(axes, 0)]

        def show(frame: int) -> None:
            drawn.pop().remove()
            drawn.append(particles.draw(axes, frame))
            clock.set_text(f"t = {times[frame]:.3f} s{flying}")

        return drawn_frames(Animation(figure, len(particles.position), show), _DPI)
