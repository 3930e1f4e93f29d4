"""Identity of the engine: number of the numerics, hash of the sources, versions of libraries."""

import hashlib
import platform
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).parents[1]

#: The numerics: run files with the same number hold the same bits for the same point, on the same
#: kind of machine. A change that alters bits (the golden points in tests/golden detect it) takes
#: the next number and a line in CHANGELOG.md. Moving, renaming or rewording a file takes none.
NUMERICS = 1

#: The numerics of engines that wrote no number into their run files, by source hash.
NUMERICS_BY_HASH = {"0b14a980090c": 1}

#: Parts of the package with the engine's sources, and those with compiled code.
ENGINE_PARTS = ("parameters", "laws", "engine")
COMPILED_PARTS = (
    "engine/compile.py",
    "engine/calls.py",
    "laws",
    "engine/contact",
    "engine/boundary",
    "engine/dynamics",
    "engine/systems",
    "engine/observe",
)


def numerics_of(attributes: Mapping[str, Any]) -> int | None:
    """Return the number of the numerics that made a run file, or None where it is unknown.

    Parameters
    ----------
    attributes : mapping
        Global attributes of the run file.
    """
    if "numerics" in attributes:
        return int(attributes["numerics"])
    return NUMERICS_BY_HASH.get(attributes.get("source_hash", ""))


def numerics_mark() -> str:
    """Return the text by which workflows detect that other numerics made a run.

    Engines before the first number recorded their source hash, which stands for their number.
    """
    return next(
        (mark for mark, number in NUMERICS_BY_HASH.items() if number == NUMERICS),
        f"numerics {NUMERICS}",
    )


def source_files(parts: Sequence[str] = ENGINE_PARTS) -> list[Path]:
    """Return the source files of parts of the package in a fixed order."""
    files: list[Path] = []
    for name in parts:
        path = PACKAGE / name
        files += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return files


def source_hash(parts: Sequence[str] = ENGINE_PARTS) -> str:
    """Return 12 hex digits that change with any source file of parts of the package.

    Run files record the hash of the engine; compiled code is valid for the hash of
    `COMPILED_PARTS`.
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
