"""Frames as text: extended XYZ and dumps of LAMMPS, in SI units."""

from collections.abc import Callable
from pathlib import Path
from typing import IO

import numpy as np

from sim.base.files import atomic_write
from sim.report.export.frames import Frame, Frames

#: Writes the head of a frame, and returns the format of the lines of its particles, whose arguments
#: are number, kind, position, velocity, radius and spin.
_Head = Callable[[IO[str], Frames, Frame, int], str]


def write_extxyz(path: Path, frames: Frames) -> None:
    """Write extended XYZ: all particles of species X, those glued to the plane of ``kind`` 2.

    The cell is in ``Lattice``, ``Origin`` and ``pbc``, the time (s) in ``Time``.
    """
    _write(path, frames, _begin_extxyz)


def write_lammps_dump(path: Path, frames: Frames) -> None:
    """Write a dump of LAMMPS in its units ``si``; particles glued to the plane have type 2."""
    _write(path, frames, _begin_dump, "ITEM: UNITS\nsi\n")


def _write(path: Path, frames: Frames, begin: _Head, title: str = "") -> None:
    labels = np.stack([np.arange(1, len(frames.kind) + 1), frames.kind], axis=1).tolist()
    with atomic_write(path) as temporary, temporary.open("w", encoding="ascii") as file:
        file.write(title)
        for frame, step in zip(frames, frames.steps, strict=True):
            line = begin(file, frames, frame, int(step))
            columns = [frame.position, frame.velocity, frames.radius[:, None]]
            if frame.spin is not None:
                columns.append(frame.spin)
            rows = np.concatenate(columns, axis=1).tolist()
            file.writelines(
                line.format(*label, *row) for label, row in zip(labels, rows, strict=True)
            )


def _begin_extxyz(file: IO[str], frames: Frames, frame: Frame, step: int) -> str:
    x, y, z = frames.high - frames.low
    origin = " ".join(f"{value:.9g}" for value in frames.low)
    periodic = " ".join("T" if is_periodic else "F" for is_periodic in frames.periodic)
    spin = "" if frame.spin is None else ":angular_velocity:R:3"
    file.write(
        f"{len(frames.radius)}\n"
        f"Properties=species:S:1:pos:R:3:velo:R:3:radius:R:1{spin}:id:I:1:kind:I:1 "
        f'Lattice="{x:.9g} 0 0 0 {y:.9g} 0 0 0 {z:.9g}" Origin="{origin}" pbc="{periodic}" '
        f"Time={frame.time:.9g} Step={step}\n"
    )
    return f"X {_numbers(frame)} {{0}} {{1}}\n"


def _begin_dump(file: IO[str], frames: Frames, frame: Frame, step: int) -> str:
    edges = " ".join("pp" if is_periodic else "ff" for is_periodic in frames.periodic)
    bounds = zip(frames.low, frames.high, strict=True)
    spin = "" if frame.spin is None else " omegax omegay omegaz"
    file.write(
        f"ITEM: TIME\n{frame.time:.9g}\nITEM: TIMESTEP\n{step}\n"
        f"ITEM: NUMBER OF ATOMS\n{len(frames.radius)}\nITEM: BOX BOUNDS {edges}\n"
    )
    file.writelines(f"{low:.9g} {high:.9g}\n" for low, high in bounds)
    file.write(f"ITEM: ATOMS id type x y z vx vy vz radius{spin}\n")
    return f"{{0}} {{1}} {_numbers(frame)}\n"


def _numbers(frame: Frame) -> str:
    """Return the format of position, velocity, radius and spin, which follow two labels.

    Nine digits distinguish any two numbers of single precision.
    """
    last = 9 if frame.spin is None else 12
    return " ".join(f"{{{place}:.9g}}" for place in range(2, last))
