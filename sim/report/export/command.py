"""The command ``export``."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import netCDF4

from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.seals import checked_read
from sim.engine.stored_run import parameters_of
from sim.report.export import amber, text, vtk
from sim.report.export.frames import Frames, frames_of

#: Suffixes of the files of each format, the usual one first, and the function that writes one.
FORMATS: dict[str, tuple[tuple[str, ...], Callable[[Path, Frames], None]]] = {
    "amber": ((".ncdf", ".nc"), amber.write_amber),
    "extxyz": ((".xyz", ".extxyz"), text.write_extxyz),
    "lammps-dump": ((".dump", ".lammpstrj"), text.write_lammps_dump),
    "vtk": ((".pvd",), vtk.write_vtk),
}


def export(path: Path, to: str, output: Path | None, replicate: int) -> str:
    """Write the trajectory of a replicate, or its first and last state, for other programs.

    Parameters
    ----------
    path : Path
        The run file.
    to : str
        One of `FORMATS`.
    output : Path, optional
        The file to write. It must not exist, and needs a suffix of the format, by which other
        programs recognise it. By default, it is named like the run file, in the present folder.
    replicate : int
        Number of the replicate, from 0.

    Returns
    -------
    str
        A line on the written file.

    Raises
    ------
    InputError
        When the run file cannot be read, has no such replicate, or the output cannot be written.
    """
    endings, write = FORMATS[to]
    if not path.name or (output and not output.name):
        raise InputError.of_value("export", "", str(output or path), "the name of a file")
    output = Path(path.with_suffix(endings[0]).name) if output is None else output
    if output.is_dir():
        allowed = f"the name of a file; {output} is a folder"
        raise InputError.of_value("--output", "", str(output), allowed)
    if output.suffix.lower() not in endings:
        allowed = f"a name that ends in {' or '.join(endings)}, as {to} does"
        raise InputError.of_value("--output", "", str(output), allowed)
    _require_new(output, to)
    with ExitStack() as opened:
        with checked_read(path, "run file", replaceable=False, sealed=True):
            file = opened.enter_context(netCDF4.Dataset(path))
            file.set_auto_mask(False)
            frames = frames_of(file, parameters_of(file, path), replicate)
        output.parent.mkdir(parents=True, exist_ok=True)
        try:
            write(output, frames)
        except RuntimeError as error:
            # The library raises this on a full disk.
            raise OSError(f"{output}: cannot be written: {error}") from None
    return f"{output}: {len(frames.times):,} frames of {len(frames.radius):,} particles"


def _require_new(output: Path, to: str) -> None:
    outputs = [output]
    if to == "vtk":
        vtk.require_library()
        outputs.append(vtk.folder_of(output))
    for path in outputs:
        if path.exists():
            raise InputError.of_value("--output", "", str(path), "a name that nothing has")
    require_writable(output.parent, "--output")
