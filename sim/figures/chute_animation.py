"""An animation of a chute flow: spheres on the plane, and their velocities over height."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from sim.figures.animation import Animation, message_animation, select
from sim.figures.configuration import COLOURS, Scene
from sim.figures.data import FigureData
from sim.figures.kind import Kind

FRAMES = 24

#: How far the fastest spheres may go from frame to frame, in diameters, for the eye to follow them.
STRIDE = 0.35

PIXELS = 330


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of the time shown."""
    (row,) = data.rows.to_dict("records")
    state = data.results.states.get(row["point"])
    if state is None or "path" not in state:
        return []
    time, _, _ = motion(state, row["diameter"])
    span = time[-1] / np.sqrt(row["diameter"] / row["gravity"])
    return [
        f"Shown are {span:.2g} √(σ/g) in slow motion after the averaging window, {FRAMES} frames; "
        f"mean velocity of the window {row['velocity']:.3g} m/s ({row['regime']})."
    ]


def motion(state: xr.Dataset, diameter: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times (F,), s, centres (F, N, 3), m, and velocities down the slope (F, N), m/s.

    They are interpolated between the states of the path, over as much of it as lets the fastest
    spheres go by no more than `STRIDE` from frame to frame.
    """
    known, path = state["path_time"].values.astype(float), state["path"].values.astype(float)
    speed = np.gradient(path[..., 0], known, axis=0)
    fastest = max(float(np.percentile(speed, 99)), 1e-9)
    time = np.linspace(0, min(known[-1], (FRAMES - 1) * STRIDE * diameter / fastest), FRAMES)
    place = np.searchsorted(known, time, side="right").clip(1, len(known) - 1)
    share = (time - known[place - 1]) / (known[place] - known[place - 1])
    return (
        time,
        _between(path[place - 1], path[place], share[:, None, None]),
        _between(speed[place - 1], speed[place], share[:, None]),
    )


def _between(first: np.ndarray, second: np.ndarray, share: np.ndarray) -> np.ndarray:
    return first + share * (second - first)


def draw(data: FigureData) -> Animation:
    """Animate the flow of the one point."""
    (row,) = data.rows.to_dict("records")
    state = data.results.states.get(row["point"])
    if state is None or "path" not in state:
        return message_animation("no motion stored")
    time, position, speed = motion(state, row["diameter"])
    unit = np.sqrt(row["diameter"] / row["gravity"])
    scene = Scene(row, state, position[..., 2], speed, PIXELS)
    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    ((pictures, profiles),) = figure.subfigures(1, 2, squeeze=False, width_ratios=(1.6, 1))
    left, right = pictures.subplots(), profiles.subplots()
    image = scene.show(left, scene.picture(position[0], speed[0]))
    heights = position[..., 2] / row["diameter"]
    (dots,) = right.plot([], [], "o", markersize=2.2, color=COLOURS(0.25), alpha=0.7)
    low, high = scene.range
    margin = 0.1 * (high - low)
    right.set_xlim(min(0.0, low - margin), high + margin)
    right.set_ylim(0, heights.max() + 0.5)
    right.set_xlabel("velocity u (m/s)")
    right.set_ylabel("height z (σ)")
    clock = left.set_title(" ", loc="left", fontsize=8.5)

    def show(number: int) -> None:
        image.set_data(scene.picture(position[number], speed[number]))
        dots.set_data(speed[number], heights[number])
        mean = round(speed[number].mean(), 3) + 0.0
        clock.set_text(f"t = {time[number] / unit:5.2f} √(σ/g), mean u = {mean:.3f} m/s")

    return Animation(figure, FRAMES, show)


KIND = Kind(draw, notes=notes, select=select)
