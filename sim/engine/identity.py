"""Identity of the engine: number of the numerics, hash of the sources, versions of libraries.

The folder of compiled code bears the hash. Its files are executed: anybody who could write there
could run code as the user, so nobody else can.
"""

import atexit
import hashlib
import logging
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from sim.base.additions import codes
from sim.base.errors import InputError
from sim.base.files import NotPrivateError, cache_folder, private_folder, user_temporary_folder

PACKAGE = Path(__file__).parents[1]

#: The numerics: run files with the same number hold the same bits for the same point, on the same
#: kind of machine. A change that alters bits (the golden points in tests/golden detect it) takes
#: the next number and a line in CHANGELOG.md. Moving, renaming or rewording a file takes none.
NUMERICS = 1

#: The numerics of engines that wrote no number into their run files, by source hash.
NUMERICS_BY_HASH = {"0b14a980090c": 1}

#: Parts of the package with the engine's sources, and those with compiled code.
ENGINE_PARTS = ("parameters", "laws", "engine", "engines")
COMPILED_PARTS = (
    "engine/compile.py",
    "laws",
    "engine/contact",
    "engine/boundary",
    "engine/dynamics",
    "engine/systems",
    "engine/observe",
)


def numerics_of(attributes: Mapping[str, Any]) -> int | None:
    """Return the number of the numerics of a run file with these global attributes, if known."""
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


log = logging.getLogger("talus")

#: Kinds of additions by plug-ins that are compiled with the engine.
COMPILED_KINDS = ("law", "motion")

_VARIABLE = "TALUS_CACHE_DIR"

#: Name of a folder of compiled code: hashes of the sources and of plug-ins.
_FOLDER_NAME = re.compile(r"[0-9a-f]{12}(-[0-9a-f]{12})?")

#: Ends of numba's files in such a folder, and of all files there.
_COMPILED = (".nbi", ".nbc")
_CACHED = (*_COMPILED, ".json", ".txt")


def cache_directory(with_plugins: bool = True) -> Path:
    """Return the folder of compiled code for the present sources and plug-ins.

    Without ``with_plugins`` the folder depends on the sources alone; it serves results that no
    plug-in changes.

    ``TALUS_CACHE_DIR`` overrides the default ``~/.cache/talus`` (``XDG_CACHE_HOME`` is honoured).
    If the default cannot be used, a folder of this user under the system's temporary folder
    replaces it. If that fails too, a folder is made that is removed when the process exits. Raises
    `InputError` when the folder in ``TALUS_CACHE_DIR`` belongs to another user, or others can write
    it.
    """
    name = source_hash(COMPILED_PARTS)
    if with_plugins and (text := codes(*COMPILED_KINDS)):
        name += f"-{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    if folder := os.environ.get(_VARIABLE):
        try:
            return private_folder(Path(folder) / name)
        except NotPrivateError as error:
            allowed = "a folder of your own that only you can write"
            raise InputError(f"environment: {_VARIABLE}: {error}; allowed: {allowed}") from None
        except OSError as error:
            return _temporary_folder(name, f"{folder}: {error.strerror or error}")
    try:
        return private_folder(cache_folder() / "talus" / name)
    except (OSError, RuntimeError, NotPrivateError) as error:
        return _temporary_folder(name, str(error))


def remove_cache() -> str:
    """Remove the folders of compiled code; return a line that says where and how much.

    The next run compiles again. A folder that holds anything else stays.
    """
    folder = Path(os.environ.get(_VARIABLE) or cache_folder() / "talus")
    size = 0
    for path in folder.glob("*"):
        if not _FOLDER_NAME.fullmatch(path.name) or path.is_symlink():
            continue
        files = [file for file in path.rglob("*") if not file.is_dir() or file.is_symlink()]
        is_ours = all(file.suffix in _CACHED or file.name.startswith("warm-") for file in files)
        if is_ours and any(file.suffix in _COMPILED for file in files):
            size += sum(file.lstat().st_size for file in files)
            shutil.rmtree(path)
    return f"{folder}: {size / 1e6:.0f} MB of compiled code removed"


@cache
def _temporary_folder(name: str, reason: str) -> Path:
    """Return a folder under the system's temporary one; log a warning with the reason once."""
    base = user_temporary_folder()
    try:
        private_folder(base)
        path = private_folder(base / name)
    except (OSError, NotPrivateError):
        path = Path(tempfile.mkdtemp(prefix="talus-"))
        atexit.register(shutil.rmtree, path, ignore_errors=True)
    log.warning("compiled code is kept in %s: %s", path, reason)
    return path
