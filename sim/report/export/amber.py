"""Frames as a netCDF file after the AMBER convention, in its units: Å, ps and degrees.

AMBER NetCDF Trajectory/Restart Convention, version 1.0, revision B. The variables
``radius`` and ``spin`` are additions; readers ignore variables that they do not know.
"""

from pathlib import Path

import netCDF4
import numpy as np

from sim.base.files import atomic_write
from sim.base.program import __version__
from sim.report.export.frames import Frames

#: Å in a metre, ps in a second.
ANGSTROM, PICOSECOND = 1e10, 1e12


def write_amber(path: Path, frames: Frames) -> None:
    """Write an AMBER trajectory with velocities and cell.

    Cells of the convention begin at the origin and are periodic in all directions. Along directions
    that are not periodic, the cell contains all frames.
    """
    with (
        atomic_write(path) as temporary,
        netCDF4.Dataset(temporary, "w", format="NETCDF3_64BIT_OFFSET") as file,
    ):
        _define(file, frames)
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


def _define(file: netCDF4.Dataset, frames: Frames) -> None:
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
