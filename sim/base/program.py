"""The program: its name, version and folders, and the rooms of its code."""

import hashlib
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path

__version__ = "0.1.0"

PACKAGE = Path(__file__).parents[1]


def program() -> str:
    """Return the command that started this process: ``talus`` or ``python -m sim``."""
    return "talus" if Path(sys.argv[0]).stem == "talus" else "python -m sim"


def package_folder(name: str) -> Path:
    """Return the folder ``workflow`` or ``config`` of this package."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name


# The rooms of the package: the rooms that each may import, and hashes of their code.
#
# Data flow from the first room to the last: parameters make points, a study lists them, the engine
# runs them, the dataset gathers the runs, figures and claims read it, and the report shows all.
# Laws, engines and papers come in as plug-ins do: no room imports them.


ROOMS: dict[str, tuple[str, ...]] = {
    "base": (),
    "parameters": ("base",),
    "study": ("parameters", "base"),
    "engine": ("parameters", "base"),
    "laws": ("engine", "parameters", "base"),
    "engines": ("laws", "engine", "parameters", "base"),
    "measures": ("parameters", "base"),
    "dataset": ("measures", "engine", "study", "parameters", "base"),
    "surrogates": ("dataset", "measures", "engine", "study", "parameters", "base"),
    "figures": ("surrogates", "dataset", "measures", "engine", "study", "parameters", "base"),
    "claims": ("dataset", "measures", "engine", "study", "parameters", "base"),
    "verify": (
        *("figures", "surrogates", "dataset", "measures", "engine", "study", "parameters", "base"),
    ),
    "papers": ("claims", "dataset", "measures", "engine", "study", "parameters", "base"),
    "report": (
        "claims",
        "figures",
        "surrogates",
        "dataset",
        "measures",
        "engine",
        "study",
        "parameters",
        "base",
    ),
}

#: Room whose edits invalidate no output: runs depend on the number of the numerics instead.
UNTRACKED = "engine"

#: Its module that reads run files: what is made of them depends on it.
READER = "engine/stored_run.py"

#: Folder of the papers, and the file of a paper's figures there. Each figure depends on its own
#: entry; the report shows all of them.
PAPERS, FIGURES = "papers", "figures.yaml"


@cache
def room_hash(package: Path, room: str) -> str:
    """Return a hash of the files of a room in the folder of the package, and of its imports.

    Of `UNTRACKED` it has `READER` alone. The hash of the report includes `PAPERS`; no other
    includes `FIGURES`.
    """
    folders = {room, *ROOMS[room], *([PAPERS] if room == "report" else [])} - {UNTRACKED}
    files = [
        path
        for folder in folders
        for path in (package / folder).rglob("*")
        if path.is_file()
        and "__pycache__" not in path.parts
        and (room == "report" or path.name != FIGURES)
    ]
    return files_hash([*files, *([package / READER] if UNTRACKED in ROOMS[room] else [])])


def files_hash(files: Iterable[Path]) -> str:
    """Return a hash of the names and contents of files; their folders do not matter."""
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:12]
