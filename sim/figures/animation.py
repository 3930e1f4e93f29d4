"""What animations share: the point that is shown, frames, and files of little size."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from sim.figures.data import FigureData

#: Resolution of the frames of a GIF, dots per inch, and how many colours they share.
DPI = 72
PALETTE = 64


@dataclass(frozen=True)
class Animation:
    """A figure that moves: ``show(number)`` puts it into the state of one of ``frames``.

    ``duration`` is the time for which each frame is shown, ms.
    """

    figure: Figure
    frames: int
    show: Callable[[int], None]
    duration: int = 70


def select(data: FigureData) -> FigureData:
    """Narrow the points to the one shown: the first with particles, published protocol first.

    The option ``point`` of a figure may be ``"slowest"``: the slowest of several goes first.
    """
    rows = data.rows
    if data.spec.options.get("point") == "slowest":
        rows = rows.sort_values(["completed", "velocity"], ascending=[False, True])
    rows = rows.sort_values("protocol", ascending=False, kind="stable")
    with_particles = rows[rows["point"].isin(list(data.results.states))]
    return replace(data, rows=(with_particles if len(with_particles) else rows)[:1])


def still(text: str) -> Animation:
    """Return a single frame that says why there is nothing to show."""
    figure = Figure(figsize=(6.4, 3.2))
    figure.subplots().set_axis_off()
    figure.axes[0].text(0.5, 0.5, text, ha="center", transform=figure.axes[0].transAxes)
    return Animation(figure, 1, lambda number: None)


def save_gif(animation: Animation, path: Path) -> None:
    """Write an endless GIF and leave the figure in the state of its last frame.

    All frames share the colours of a few of them, so that none flickers.
    """
    figure = animation.figure
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(DPI)
    # The layout of the first frame is kept: texts that change would move the axes.
    animation.show(0)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    frames = []
    for number in range(animation.frames):
        animation.show(number)
        canvas.draw()
        frames.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    sample = Image.fromarray(np.concatenate(frames[:: max(1, len(frames) // 4)]))
    # Of these methods the one that keeps colours of few pixels, as lines have.
    coverage = Image.Quantize.MAXCOVERAGE
    palette = sample.quantize(PALETTE, method=coverage, dither=Image.Dither.NONE)
    images = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    options = {"save_all": True, "loop": 0, "duration": animation.duration}
    images[0].save(path, format="GIF", append_images=images[1:], **options)
