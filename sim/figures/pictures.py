"""Pictures as files: small PNGs and SVGs, animations, and a record of what each was drawn from."""

import hashlib
import json
import os
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo
from pydantic import BaseModel, TypeAdapter, ValidationError

from sim.base.files import atomic_write, open_regular, read_regular
from sim.base.seals import checked_read
from sim.study.figure_spec import FigureSpec

#: Resolution of the first picture of an animation, dots per inch.
_POSTER = 150

#: Resolution of the frames of an animation, dots per inch, and number of colours that they share.
_DPI, _PALETTE = 72, 32

#: A number with more digits than a picture shows, except a scale.
_LONG_NUMBER = re.compile(r"(?<!scale\()(?<![\w.#])(-?\d+\.\d\d)\d{2,}(?![\w.])")

#: Most passes of the layout.
_PASSES = 6


@dataclass(frozen=True)
class Animation:
    """A moving figure with ``frames`` frames; ``show(number)`` puts it into the state of one.

    ``duration`` is how long each frame is shown, ms.
    """

    figure: Figure
    frames: int
    show: Callable[[int], None]
    duration: int = 70


def with_short_numbers(svg: str) -> str:
    """Return an SVG picture with places to a hundredth of a point; scales keep their digits.

    >>> with_short_numbers('<use x="56.870777" transform="scale(0.015625)"/>')
    '<use x="56.87" transform="scale(0.015625)"/>'
    """
    return _LONG_NUMBER.sub(r"\1", svg)


def settle(figure: Figure) -> None:
    """Repeat the layout of a figure until its axes stay in place.

    The first pass does not know the final size of axes with a fixed aspect, and may leave their
    labels beyond the edges.
    """
    engine, bounds = figure.get_layout_engine(), None
    for _ in range(_PASSES):
        previous, bounds = bounds, [axes.get_position().bounds for axes in figure.axes]
        if engine is None or (previous and np.allclose(previous, bounds, atol=1e-3)):
            break
        engine.execute(figure)


def keep_layout(figure: Figure) -> None:
    """Let a figure keep its layout: each file would lay it out, and draw it for that, once more."""
    with mpl.rc_context({"figure.constrained_layout.use": False, "figure.autolayout": False}):
        figure.set_layout_engine(None)


def save_picture(figure: Figure, title: str, svg: Path | None, png: Path) -> None:
    """Write a picture with its title; the PNG has 256 colours, a third of its size.

    Without a date, the same data give the same bytes. Without ``svg`` it is one of an animation.
    """
    if svg:
        keep_layout(figure)
        figure.savefig(svg, format="svg", metadata={"Title": title, "Date": None})
        text = with_short_numbers(svg.read_text(encoding="utf-8"))
        svg.write_text(text, encoding="utf-8")
    figure.savefig(png, format="png", dpi=None if svg else _POSTER)
    with Image.open(png) as image:
        small = image.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    metadata = PngInfo()
    metadata.add_itxt("Title", title)
    small.save(png, format="PNG", optimize=True, pnginfo=metadata, dpi=image.info.get("dpi"))


def save_animation(animation: Animation, file: Path) -> None:
    """Write an endless ``"GIF"`` and leave the figure in the state of its last frame."""
    save_frames(drawn_frames(animation, _DPI), animation.duration, file, "GIF")


def save_frames(images: list[Image.Image], duration: int, file: Path | BinaryIO, kind: str) -> None:
    """Write an endless ``"GIF"`` or ``"WebP"`` of frames that are shown for some ms each.

    All frames of a GIF share one palette, taken from a few of them, so that none flickers.
    """
    options: dict[str, Any] = {"quality": 75}
    if kind == "GIF":
        few = [np.asarray(image) for image in images[:: max(1, len(images) // 4)]]
        sample = Image.fromarray(np.concatenate(few))
        # This method keeps colours that only a few pixels have, like those of lines.
        no_dither, coverage = Image.Dither.NONE, Image.Quantize.MAXCOVERAGE
        palette = sample.quantize(_PALETTE, method=coverage, dither=no_dither)
        images = [image.quantize(palette=palette, dither=no_dither) for image in images]
        options = {}
    options |= {"save_all": True, "loop": 0, "duration": duration}
    images[0].save(file, format=kind, append_images=images[1:], **options)


def drawn_frames(animation: Animation, dpi: int) -> list[Image.Image]:
    """Return the frames of an animation as images."""
    figure = animation.figure
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(dpi)
    # All frames have the layout of the first: texts that change would move the axes.
    animation.show(0)
    settle(figure)
    keep_layout(figure)
    images = []
    for number in range(animation.frames):
        animation.show(number)
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()))
    return images


# A file of records in the folder of figures: the source of each, and checksums of its files.

#: Name of the file of records in the folder of the figures.
RECORD_FILE = ".drawn.json"

#: Bytes at the end of a dataset that identify it; its seal is among them.
TAIL = 128


class FigureRecord(BaseModel):
    """The hash of what a figure was drawn from, and the SHA-256 of its files by suffix."""

    source: str
    files: dict[str, str]


_RECORDS = TypeAdapter(dict[str, FigureRecord])


def read_records(folder: Path) -> dict[str, FigureRecord]:
    """Return the record of each figure drawn in a folder; empty where none can be read."""
    try:
        return _RECORDS.validate_json(read_regular(folder / RECORD_FILE))
    except (FileNotFoundError, ValidationError):
        return {}


def write_records(folder: Path, records: dict[str, FigureRecord]) -> None:
    """Write the records of the figures in a folder; the file appears complete or not at all."""
    with atomic_write(folder / RECORD_FILE) as temporary:
        entries = {name: record.model_dump() for name, record in records.items()}
        temporary.write_text(json.dumps(entries, indent=1), encoding="utf-8")


def current_record(
    spec: FigureSpec, dataset_path: Path, folder: Path, code: str
) -> FigureRecord | None:
    """Return the record of a figure as its files are now, or None where a file is missing.

    It was drawn by ``code`` from an entry of the catalogue, a dataset, and its answer, if any.
    """
    source = hashlib.sha256(f"{code} {spec!r}".encode())
    try:
        with open_regular(dataset_path) as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL))
            source.update(file.read())
        if spec.answer.file:
            source.update(read_regular(dataset_path.parent / spec.answer.file))
        files = {suffix: _checksum(folder / f"{spec.name}{suffix}") for suffix in spec.suffixes}
    except OSError:
        return None
    return FigureRecord(source=source.hexdigest(), files=files)


def require_unchanged(specs: Iterable[FigureSpec], folder: Path) -> None:
    """Raise an error unless the files of all figures are those that were drawn.

    It is ``InputError`` where a file is missing, and ``DamagedError`` for the first one that has
    changed or has no record, which is set aside.
    """
    records = read_records(folder)
    for spec in specs:
        checksums = records[spec.name].files if spec.name in records else {}
        for suffix in spec.suffixes:
            path = folder / f"{spec.name}{suffix}"
            with checked_read(path, "file of a figure", replaceable=True):
                if suffix not in checksums:
                    raise ValueError(f"{RECORD_FILE} does not know it")
                if _checksum(path) != checksums[suffix]:
                    raise ValueError("the checksum is wrong")


def _checksum(path: Path) -> str:
    return hashlib.sha256(read_regular(path)).hexdigest()
