"""What made a result: the hash of the engine's sources and the versions of its libraries."""

import hashlib
import platform
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).parent

#: Everything that can change a number in a run file. Figures, reports and the command line are not
#: part of it, so that editing them reruns nothing.
ENGINE = (
    "parameters",
    "parameters.py",
    "compile.py",
    "contact",
    "boundary",
    "dynamics",
    "systems",
    "observe",
    "checkpoint.py",
    "replicate.py",
    "run.py",
)


def engine_files() -> list[Path]:
    """Return the engine's source files in a fixed order."""
    files: list[Path] = []
    for name in ENGINE:
        path = PACKAGE / name
        files += sorted(path.rglob("*.py")) if path.is_dir() else [path] if path.exists() else []
    return files


def source_hash() -> str:
    """Return 12 hex digits that change whenever a source file of the engine changes."""
    digest = hashlib.sha256()
    for path in engine_files():
        digest.update(path.relative_to(PACKAGE).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def library_versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries that compute or store numbers."""
    names = ("numpy", "scipy", "pymbar", "numba", "llvmlite", "netCDF4", "pydantic")
    return {"python": platform.python_version()} | {name: version(name) for name in names}
