"""Animations: spheres on an inclined plane, beads over one cycle, and the particles of one run."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from io import BytesIO
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from PIL import Image

from sim.figures.beads import OBSTACLE
from sim.figures.caption import velocity_text
from sim.figures.data import FigureData, label_with_unit, point_table
from sim.figures.plot import message_figure
from sim.figures.render import Animation, settle
from sim.figures.spheres import COLOURS, DARK, Scene, across_sides, draw_particles
from sim.figures.style import SETTINGS, SHORT_DASH
from sim.study.plottable import TALLEST

#: Number of frames of a chute flow.
FRAMES = 24

#: How far the fastest spheres may go from frame to frame, in diameters, for the eye to follow them.
STRIDE = 0.35

#: A frame shows one state of so many of the path, for so long (ms).
EVERY, DURATION = 2, 130

#: Beads whose paths are drawn, and distance of the marks on the belt, in mean diameters.
_FOLLOWED, _MARKS = 8, 2.0


def select(data: FigureData) -> FigureData:
    """Return the data with a single point: the first with particles, published protocol first.

    With the option ``point: "slowest"`` of a figure, slower flows precede faster ones. Without any
    particles, the first point is taken.
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
    state = _path_of(data)
    if state is None:
        return Animation(message_figure("no motion stored"), 1, lambda number: None)
    return (_animate_belt if data.spec.system == "belt" else _animate_chute)(row, state)


#: The data behind it are those of its point.
table = point_table


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of the flow, or of the time shown of it."""
    (row,) = data.rows.to_dict("records")
    if data.spec.system == "belt":
        mean = f"Transport velocity of the averaging window {velocity_text(row)} ({row['regime']})."
        return [mean] if row["completed"] else []
    state = _path_of(data)
    if state is None:
        return []
    time, _, _ = motion(state, row["diameter"])
    span = time[-1] / np.sqrt(row["diameter"] / row["gravity"])
    return [
        f"Shown are {span:.2g} √(σ/g) in slow motion after the averaging window, {FRAMES} frames; "
        f"mean velocity of the window {row['velocity']:.3g} m/s ({row['regime']})."
    ]


def _path_of(data: FigureData) -> xr.Dataset | None:
    """Return the particles of the one point, None without their path."""
    state = data.results.states.get(data.rows["point"].iloc[0])
    return None if state is None or "path" not in state else state


def _animate_chute(row: Mapping[str, Any], state: xr.Dataset) -> Animation:
    time, position, speed = motion(state, row["diameter"])
    unit = np.sqrt(row["diameter"] / row["gravity"])
    scene = Scene(row, state, position[..., 2], speed)
    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    ((pictures, profiles),) = figure.subfigures(1, 2, squeeze=False, width_ratios=(1.6, 1))
    left, right = pictures.subplots(), profiles.subplots()
    scene.prepare(left)
    spheres = [scene.draw(left, position[0], speed[0])]
    heights = position[..., 2] / row["diameter"]
    (dots,) = right.plot([], [], "o", markersize=2.2, color=COLOURS(0.25), alpha=0.7)
    low, high = scene.range
    margin = 0.1 * (high - low)
    right.set_xlim(min(0.0, low - margin), high + margin)
    right.set_ylim(0, heights.max() + 0.5)
    right.set_xlabel("velocity u (m/s)")
    right.set_ylabel("height z/σ")
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
    instants, path = state["path_time"].values.astype(float), state["path"].values.astype(float)
    speed = np.gradient(path[..., 0], instants, axis=0)
    fastest = max(float(np.percentile(speed, 99)), 1e-9)
    time = np.linspace(0, min(instants[-1], (FRAMES - 1) * STRIDE * diameter / fastest), FRAMES)
    place = np.searchsorted(instants, time, side="right").clip(1, len(instants) - 1)
    share = (time - instants[place - 1]) / (instants[place] - instants[place - 1])
    return (
        time,
        _between(path[place - 1], path[place], share[:, None, None]),
        _between(speed[place - 1], speed[place], share[:, None]),
    )


def _between(first: np.ndarray, second: np.ndarray, share: np.ndarray) -> np.ndarray:
    return first + share * (second - first)


def _animate_belt(row: Mapping[str, Any], state: xr.Dataset) -> Animation:
    belt = BeltScene(row, state)
    # To scale, with room for the axes and the colours.
    aspect = (belt.top - belt.low) / belt.width
    width = min(4.8, 4.8 / aspect)
    figure = Figure(figsize=(width + 1.6, width * aspect + 0.9), layout="constrained")
    axes = figure.subplots()
    beads = [belt.draw(axes, 0)]
    _draw_surroundings(axes, belt)
    (line,) = axes.plot([], [], color=DARK, linewidth=2.2, zorder=3)
    (marks,) = axes.plot([], [], "|", color=DARK, markersize=6, markeredgewidth=1.4, zorder=3)
    (trails,) = axes.plot(
        [], [], color="#d55e00", linewidth=0.9, marker=".", markersize=2, zorder=4
    )
    clock = axes.set_title(" ", loc="left", fontsize=8.5)

    def show(frame: int) -> None:
        number = EVERY * frame
        beads.pop().remove()
        beads.append(belt.draw(axes, number))
        places, level = belt.line(number)
        line.set_data([0, belt.width], [level, level])
        marks.set_data(places, np.full(len(places), level - 0.25))
        trails.set_data(*belt.trails(number).T)
        share = belt.time[number] * row["frequency"]
        clock.set_text(f"f = {row['frequency']:g} Hz, t = {share:.2f} cycles")

    return Animation(figure, (len(belt.time) - 1) // EVERY, show, DURATION)


class BeltScene:
    """Beads and belt in mean diameters: ``path`` (S, N, 2), ``time`` (S,), ``speed`` (S, N)."""

    def __init__(self, row: Mapping[str, Any], state: xr.Dataset):
        self.row, unit = row, row["diameter"]
        self.path = state["path"].values.astype(float) / unit
        self.time = state["path_time"].values.astype(float)
        self.speed = unit * np.gradient(self.path[..., 0], self.time, axis=0)
        self.size = 2 * state["radius"].values / unit
        self.width, self.amplitude = row["width"], row["amplitude"]
        self.norm = Normalize(*np.percentile(self.speed, (1, 99)))
        self.low = -self.amplitude - 1.0
        self.top = min(float(self.path[..., 1].max()) + 1.0, TALLEST)

    def draw(self, axes: Axes, number: int) -> EllipseCollection:
        """Draw the beads of a state."""
        index, x = across_sides(self.path[number, :, 0], self.size, self.width)
        place = np.column_stack([x, self.path[number, index, 1]])
        colour = COLOURS(self.norm(self.speed[number, index]))
        edge: dict[str, Any] = {"edgecolors": DARK, "linewidths": 0.3, "zorder": 2}
        return draw_particles(axes, place, self.size[index], colour, **edge)

    def line(self, number: int) -> tuple[np.ndarray, float]:
        """Return where the marks on the belt are (M,), and its height."""
        angle = 2 * np.pi * self.row["frequency"] * self.time[number]
        phase = np.sin(angle + np.radians(self.row["phase"]))
        slope = np.tan(np.radians(self.row["vibration_angle"]))
        marks = np.arange(-2 * _MARKS, self.width + 2 * _MARKS, _MARKS)
        return marks + self.amplitude / slope * phase, self.amplitude * phase

    def trails(self, number: int) -> np.ndarray:
        """Return the paths (P, 2) of some beads up to a state, parted by not-a-number."""
        followed = np.argsort(self.path[0, :, 0])[:: max(1, len(self.size) // _FOLLOWED)]
        path = self.path[: number + 1, followed].copy()
        path[..., 0] -= self.width * (self.path[0, followed, 0] // self.width)
        gap = np.full((1, len(followed), 2), np.nan)
        return np.concatenate([path, gap]).transpose(1, 0, 2).reshape(-1, 2)


def _draw_surroundings(axes: Axes, belt: BeltScene) -> None:
    """Draw the belt's extreme positions, an obstacle, the axes and the colours."""
    for level in (-belt.amplitude, belt.amplitude):
        axes.axhline(level, color="#888888", linestyle=SHORT_DASH, linewidth=0.8, zorder=1)
    if belt.row["obstacle"]:
        centre, radius = (belt.width / 2, belt.amplitude), belt.row["obstacle"] / 2
        axes.add_patch(Circle(centre, radius, facecolor=OBSTACLE, edgecolor=DARK, zorder=3))
    axes.set(xlim=(0, belt.width), ylim=(belt.low, belt.top), aspect="equal")
    axes.grid(visible=False)
    axes.set_xlabel("along the belt x/⟨d⟩")
    axes.set_ylabel("height z/⟨d⟩")
    shades = ScalarMappable(belt.norm, COLOURS)
    look: dict[str, Any] = {"aspect": 25, "pad": 0.02, "shrink": 0.8}
    axes.figure.colorbar(shades, ax=axes, label="velocity $v_x$ (m/s)", **look)


# The particles of one run, which `talus export` writes.


#: Most inches of a picture's width, of its height, and of a diameter in it.
_MOST_WIDTH, _MOST_HEIGHT, _MOST_DIAMETER = 7.4, 6.0, 0.5

#: Dots per inch of an animation, and milliseconds per frame.
_DPI, _DURATION = 100, 100

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


def run_animation(frames: ParticleFrames) -> bytes:
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
    options = {"save_all": True, "loop": 0, "duration": _DURATION, "quality": 75}
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
