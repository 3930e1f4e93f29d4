"""Golden points: short runs whose numbers are kept, to tell whether a change alters them.

``bits.json`` holds for each kind of machine the SHA-256 of everything in each point's run file;
``values.json`` the first samples of its time series, which other machines must meet to 1e-9.
``python -m tests.golden`` compares, ``python -m tests.golden --record`` writes both anew.
"""

import hashlib
import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import llvmlite.binding
import netCDF4
import numba
import numpy as np
import yaml

from sim.engine.run import run_point
from sim.engine.systems import build
from sim.parameters import Parameters, parse_point

FOLDER = Path(__file__).parent
BITS, VALUES = FOLDER / "bits.json", FOLDER / "values.json"

#: Samples of the time series that are compared by value: later ones depend on the last bit.
EARLY = {"chute": 4, "belt": 12, "conveyor": 4}
TOLERANCE = 1e-9

#: Points that blow up before their first sample.
FAILING = ("chute_failed",)

#: What differs from run to run.
CLOCK = ("wall_time", "loop_time")


def points() -> dict[str, Parameters]:
    """Return the golden points by name."""
    source = FOLDER / "points.yaml"
    given = yaml.safe_load(source.read_text(encoding="utf-8"))
    return {name: parse_point(values, f"{source.name}: {name}") for name, values in given.items()}


def machine() -> str:
    """Name what the bits of a result depend on besides the program: what it is compiled for and by.

    Each Python has a bytecode of its own, from which the loops are compiled.
    """
    libraries = ("numpy", "scipy", "numba", "llvmlite")
    processor = numba.config.CPU_NAME or llvmlite.binding.get_host_cpu_name()
    parts = [processor, "-".join(platform.libc_ver())]
    parts.append("python-" + ".".join(platform.python_version_tuple()[:2]))
    return " ".join(parts + [f"{name}-{version(name)}" for name in libraries])


def computed(parameters: Parameters, folder: Path) -> Path:
    """Run a point into a folder, or run on what was interrupted there, and return its file."""
    folder.mkdir(exist_ok=True)
    path = folder / "run.nc"
    path.unlink(missing_ok=True)
    run_point(parameters, path, quiet=True, record_failure=True)
    return path


def contents(path: Path) -> dict[str, np.ndarray]:
    """Return all variables of a run file that a second run would write again."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        names = sorted(set(file.variables) - set(CLOCK))
        return {name: np.asarray(file[name][...]) for name in names}


def digest(path: Path) -> str:
    """Return the SHA-256 of names, shapes and values of everything in a run file."""
    found = hashlib.sha256()
    for name, values in contents(path).items():
        text = values.dtype.kind in "OU"
        # Words as strings and as letters are the same.
        kind = "object" if text and values.ndim else values.dtype
        found.update(f"{name} {values.shape} {kind}\n".encode())
        found.update("\n".join(map(str, values.flat)).encode() if text else values.tobytes())
    return found.hexdigest()


def early(parameters: Parameters) -> dict[str, list[float]]:
    """Return the first samples of every time series, without the settling of a belt's bed.

    Collisions make any difference grow a hundredfold or more; so few are too early for that.
    """
    system = build(parameters, 0)
    samples = [system.advance() for _ in range(EARLY[parameters.system])]
    return {name: [float(sample[name]) for sample in samples] for name in system.series}


def worst_error(parameters: Parameters, found: Mapping, expected: Mapping) -> float:
    """Return the largest difference of two early records, relative to all series of its unit."""
    units = {name: row.unit for name, row in build(parameters, 0).series.items()}
    largest: dict[str, float] = {}
    for name, values in expected.items():
        largest[units[name]] = max(largest.get(units[name], 0.0), *map(abs, values))
    errors = [
        abs(one - other) / largest[units[name]]
        for name, values in expected.items()
        for one, other in zip(found[name], values, strict=True)
        if one != other
    ]
    return max(errors, default=0.0)


def stored(path: Path) -> dict:
    """Return the contents of one of the two files of this folder."""
    return json.loads(path.read_text(encoding="utf-8"))
