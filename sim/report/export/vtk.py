"""Frames as VTU files, and a PVD file that lists them with their times, in SI units."""

import shutil
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.report.export.frames import Frames


def folder_of(path: Path) -> Path:
    """Return the folder of the frames that a PVD file lists."""
    return path.with_suffix("")


def require_library() -> None:
    """Raise `InputError` where the library that writes VTU is not installed."""
    try:
        import meshio  # noqa: F401
    except ImportError:
        allowed = "another format, or vtk once meshio is there (pip install meshio)"
        raise InputError.of_value("--to", "", "vtk", allowed) from None


def write_vtk(path: Path, frames: Frames) -> None:
    """Write a PVD file, and beside it a folder of the same name with a VTU file per frame.

    Points have ``radius``, ``velocity``, ``spin`` and ``kind``; ``cell.vtu`` is the box.
    """
    import meshio

    folder = folder_of(path)
    part = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir()
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    vertices = [("vertex", np.arange(len(frames.radius))[:, None])]
    try:
        for number, frame in enumerate(frames):
            data = {"radius": frames.radius, "kind": frames.kind, "velocity": frame.velocity}
            if frame.spin is not None:
                data["spin"] = frame.spin
            name = f"{number:06}.vtu"
            meshio.Mesh(frame.position, vertices, data).write(part / name)
            attributes = {"timestep": f"{frame.time:.9g}", "file": f"{folder.name}/{name}"}
            ElementTree.SubElement(collection, "DataSet", attributes)
        meshio.Mesh(_corners(frames), [("hexahedron", _HEXAHEDRON)]).write(part / "cell.vtu")
        with atomic_write(path) as temporary:
            ElementTree.ElementTree(root).write(temporary, encoding="utf-8", xml_declaration=True)
            part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)


#: Indices of the corners of a box (x varies slowest) in the order of VTK.
_HEXAHEDRON = np.array([[0, 4, 6, 2, 1, 5, 7, 3]])


def _corners(frames: Frames) -> np.ndarray:
    """Return the corners of the cell (8, 3); x varies slowest."""
    return np.array(list(product(*zip(frames.low, frames.high, strict=True))))
