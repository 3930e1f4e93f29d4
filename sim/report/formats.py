"""Formats of other programs for particles: AMBER, extended XYZ, LAMMPS, VTK; and movies."""

from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from typing import IO
from xml.etree import ElementTree

import netCDF4
import numpy as np

from sim.base.files import atomic_write, temporary_folder
from sim.base.program import __version__
from sim.report.movie import Frame, Frames, write_movie

#: Å in a metre, ps in a second.
ANGSTROM, PICOSECOND = 1e10, 1e12

#: Indices of the corners of a box (x varies slowest) in the order of VTK.
_HEXAHEDRON = np.array([[0, 4, 6, 2, 1, 5, 7, 3]])

#: Writes the head of a frame, and returns the format of the lines of its particles, whose arguments
#: are number, kind, position, velocity, radius and spin.
_Head = Callable[[IO[str], Frames, Frame, int], str]


def write_amber(path: Path, frames: Frames) -> None:
    """Write a netCDF file after the AMBER convention, in its units: Å, ps and degrees.

    It follows the AMBER NetCDF Trajectory/Restart Convention, version 1.0, revision B. The
    variables ``radius`` and ``spin`` are additions; readers ignore variables that they do not know.
    Cells of the convention begin at the origin and are periodic in all directions. Along directions
    that are not periodic, the cell contains all frames.
    """
    with (
        atomic_write(path) as temporary,
        netCDF4.Dataset(temporary, "w", format="NETCDF3_64BIT_OFFSET") as file,
    ):
        _define_amber(file, frames)
        lengths = (frames.high - frames.low) * ANGSTROM
        for number, frame in enumerate(frames):
            file["time"][number] = frame.time * PICOSECOND
            file["coordinates"][number] = frame.position * ANGSTROM
            file["velocities"][number] = frame.velocity * (ANGSTROM / PICOSECOND)
            file["cell_lengths"][number] = lengths
            file["cell_angles"][number] = 90.0
            file["radius"][number] = frames.radius * ANGSTROM
            if frame.spin is not None:
                file["spin"][number] = frame.spin / PICOSECOND


def _define_amber(file: netCDF4.Dataset, frames: Frames) -> None:
    file.setncatts(
        {
            "Conventions": "AMBER",
            "ConventionVersion": "1.0",
            "program": "Talus",
            "programVersion": __version__,
        }
    )
    sizes = {"spatial": 3, "atom": len(frames.radius), "cell_spatial": 3, "cell_angular": 3}
    for name, size in ({"frame": None, "label": 5} | sizes).items():
        file.createDimension(name, size)
    file.createVariable("spatial", "S1", ("spatial",))[:] = list("xyz")
    file.createVariable("cell_spatial", "S1", ("cell_spatial",))[:] = list("abc")
    angles = netCDF4.stringtochar(np.array([b"alpha", b"beta ", b"gamma"]))
    file.createVariable("cell_angular", "S1", ("cell_angular", "label"))[:] = angles
    vectors = ("frame", "atom", "spatial")
    variables = {
        "time": ("f4", ("frame",), "picosecond"),
        "coordinates": ("f4", vectors, "angstrom"),
        "velocities": ("f4", vectors, "angstrom/picosecond"),
        "cell_lengths": ("f8", ("frame", "cell_spatial"), "angstrom"),
        "cell_angles": ("f8", ("frame", "cell_angular"), "degree"),
        "radius": ("f4", ("frame", "atom"), "angstrom"),
    }
    if frames.has_spin:
        variables["spin"] = ("f4", vectors, "radian/picosecond")
    for name, (kind, dimensions, unit) in variables.items():
        file.createVariable(name, kind, dimensions).units = unit


def _write_text(path: Path, frames: Frames, begin: _Head, title: str = "") -> None:
    """Write a text file with a head and a line per particle for each frame."""
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
    """Extended XYZ: all particles of species X, those glued to the plane of ``kind`` 2.

    The cell is in ``Lattice``, ``Origin`` and ``pbc``, the time (s) in ``Time``.
    """
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
    """A dump of LAMMPS in its units ``si``; particles glued to the plane have type 2."""
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


def write_vtk(path: Path, frames: Frames) -> None:
    """Write a PVD file, and beside it a folder of the same name with a VTU file per frame.

    Points have ``radius``, ``velocity``, ``spin`` and ``kind``; ``cell.vtu`` is the box.
    """
    import meshio

    folder = path.with_suffix("")
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    vertices = [("vertex", np.arange(len(frames.radius))[:, None])]
    with temporary_folder(folder) as part:
        new_folder = part / folder.name
        new_folder.mkdir()
        for number, frame in enumerate(frames):
            data = {"radius": frames.radius, "kind": frames.kind, "velocity": frame.velocity}
            if frame.spin is not None:
                data["spin"] = frame.spin
            name = f"{number:06}.vtu"
            meshio.Mesh(frame.position, vertices, data).write(new_folder / name)
            attributes = {"timestep": f"{frame.time:.9g}", "file": f"{folder.name}/{name}"}
            ElementTree.SubElement(collection, "DataSet", attributes)
        corners = np.array(list(product(*zip(frames.low, frames.high, strict=True))))
        meshio.Mesh(corners, [("hexahedron", _HEXAHEDRON)]).write(new_folder / "cell.vtu")
        with atomic_write(path) as temporary:
            ElementTree.ElementTree(root).write(temporary, encoding="utf-8", xml_declaration=True)
            new_folder.rename(folder)


#: Suffixes of the files of each format, the usual one first, and the function that writes one.
FORMATS: dict[str, tuple[tuple[str, ...], Callable[[Path, Frames], None]]] = {
    "amber": ((".ncdf", ".nc"), write_amber),
    "extxyz": ((".xyz", ".extxyz"), partial(_write_text, begin=_begin_extxyz)),
    "lammps-dump": (
        (".dump", ".lammpstrj"),
        partial(_write_text, begin=_begin_dump, title="ITEM: UNITS\nsi\n"),
    ),
    "vtk": ((".pvd",), write_vtk),
    "gif": ((".gif",), write_movie),
    "html": ((".html",), write_movie),
    "webp": ((".webp",), write_movie),
}
