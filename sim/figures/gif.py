"""Moving figures: their frames, and small GIF files."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

#: Resolution of the frames of a GIF (dots per inch), and the number of colours that they share.
DPI = 72
PALETTE = 64


@dataclass(frozen=True)
class Animation:
    """A moving figure with ``frames`` frames; ``show(number)`` puts it into the state of one.

    ``duration`` is how long each frame is shown, ms.
    """

    figure: Figure
    frames: int
    show: Callable[[int], None]
    duration: int = 70


def message_animation(text: str) -> Animation:
    """Return an animation of one frame with a message, where there is nothing to show."""
    figure = Figure(figsize=(6.4, 3.2))
    figure.subplots().set_axis_off()
    figure.axes[0].text(0.5, 0.5, text, ha="center", transform=figure.axes[0].transAxes)
    return Animation(figure, 1, lambda number: None)


def save_gif(animation: Animation, path: Path) -> None:
    """Write an endless GIF and leave the figure in the state of its last frame.

    All frames share one palette, taken from a few of them, so that none flickers.
    """
    figure = animation.figure
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(DPI)
    # All frames have the layout of the first: texts that change would move the axes.
    animation.show(0)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    frames = []
    for number in range(animation.frames):
        animation.show(number)
        canvas.draw()
        frames.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    sample = Image.fromarray(np.concatenate(frames[:: max(1, len(frames) // 4)]))
    # This method keeps colours that only a few pixels have, like those of lines.
    coverage = Image.Quantize.MAXCOVERAGE
    palette = sample.quantize(PALETTE, method=coverage, dither=Image.Dither.NONE)
    images = [
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    ]
    options = {"save_all": True, "loop": 0, "duration": animation.duration}
    images[0].save(path, format="GIF", append_images=images[1:], **options)
