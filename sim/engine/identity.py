"""What made a result: the number of the numerics, the hash of the sources, the libraries."""

import hashlib
import platform
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).parents[1]

#: The numerics: run files of one number hold the same bits for the same point, on the same kind of
#: machine. A change that alters bits (the golden points in tests/golden tell) takes the next number
#: and a line in CHANGELOG.md. Moving, renaming or rewording a file takes none.
NUMERICS = 1

#: Source hashes of engines that wrote no number into their run files, and their number.
KNOWN = {"0b14a980090c": 1}

#: Where the engine's sources lie, and which of them hold compiled code.
ENGINE = ("parameters", "engine")
COMPILED = (
    "engine/compile.py",
    "engine/calls.py",
    "engine/contact",
    "engine/boundary",
    "engine/dynamics",
    "engine/systems",
    "engine/observe",
)


def numerics_of(attributes: Mapping[str, Any]) -> int | None:
    """Return the number of the numerics that made a run file, or None where nobody knows it.

    Parameters
    ----------
    attributes : mapping
        Global attributes of the run file.
    """
    if "numerics" in attributes:
        return int(attributes["numerics"])
    return KNOWN.get(attributes.get("source_hash", ""))


def numerics_mark() -> str:
    """Return the text by which workflows see that other numerics made a run.

    Engines before the first number noted their source hash, so that stands for their number.
    """
    return next(
        (mark for mark, number in KNOWN.items() if number == NUMERICS), f"numerics {NUMERICS}"
    )


def source_files(parts: Sequence[str] = ENGINE) -> list[Path]:
    """Return the source files of parts of the package in a fixed order."""
    files: list[Path] = []
    for name in parts:
        path = PACKAGE / name
        files += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return files


def source_hash(parts: Sequence[str] = ENGINE) -> str:
    """Return 12 hex digits that change with any source file of parts of the package.

    Run files tell that of the engine, compiled code belongs to that of `COMPILED`.
    """
    digest = hashlib.sha256()
    for path in source_files(parts):
        digest.update(path.relative_to(PACKAGE).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


@cache
def library_versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries that compute or store numbers."""
    names = ("numpy", "scipy", "numba", "llvmlite", "netCDF4", "pydantic")
    return {"python": platform.python_version()} | {name: version(name) for name in names}
