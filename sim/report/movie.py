"""The frames of a replicate, and movies of them."""

from base64 import b64encode
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sim.base.files import atomic_write
from sim.report.numbers import template

#: Most frames of a movie, and how long each is shown, ms.
MOST_FRAMES, _DURATION = 60, 100


class Frame(NamedTuple):
    """A state of the particles: ``time`` (s), ``position`` (m), ``velocity`` (m/s) and ``spin``
    (1/s), each (N, 3); beads of the belt have no spin."""

    time: float
    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray | None


@dataclass(frozen=True)
class Frames:
    """The frames of a replicate; ``read`` reads one by its number.

    ``radius`` (N,) are the radii of the particles (m); ``kind`` (N,) is 1 for moving particles and
    2 for those glued to the plane. ``low`` and ``high`` (3,) are corners of the cell (m), and
    ``periodic`` (3,) is true along its periodic directions. ``times`` (F,) are those of the frames
    (s), and ``steps`` (F,) the numbers of time steps until then.
    """

    radius: np.ndarray
    kind: np.ndarray
    low: np.ndarray
    high: np.ndarray
    periodic: tuple[bool, bool, bool]
    times: np.ndarray
    steps: np.ndarray
    has_spin: bool
    read: Callable[[int], Frame]

    def __iter__(self) -> Iterator[Frame]:
        return map(self.read, range(len(self.times)))


def write_movie(path: Path, frames: Frames) -> None:
    """Write an endless GIF or WebP, or a page with a player, of frames in diameters seen along y.

    The suffix of the path says which. Of more than `MOST_FRAMES` frames some are left out.
    """
    # Imported here: other formats need no pictures.
    from sim.figures.animation import ParticleFrames, run_frames
    from sim.figures.pictures import save_frames

    chosen = np.unique(np.linspace(0, len(frames.times) - 1, MOST_FRAMES).astype(int))
    shown = [frames.read(int(number)) for number in chosen]
    diameter = 2 * float(frames.radius.mean())
    particles = ParticleFrames(
        np.stack([frame.position for frame in shown]) / diameter,
        np.stack([frame.velocity[:, 0] for frame in shown]),
        2 * frames.radius / diameter,
        float(frames.high[0] - frames.low[0]) / diameter,
    )
    times = [frame.time for frame in shown]
    images, kind = run_frames(particles, times), path.suffix.lower()
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        if kind != ".html":
            save_frames(images, _DURATION, file, {".gif": "GIF", ".webp": "WebP"}[kind])
            return
        sources = []
        for image in images:
            content = BytesIO()
            image.save(content, "WebP", quality=75)
            sources.append(b64encode(content.getvalue()).decode("ascii"))
        page = template("movie.html.j2").render(
            name=path.stem, sources=sources, times=times, duration=_DURATION, size=images[0].size
        )
        file.write(page.encode("utf-8"))
