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


#: The rooms of the package, each with those just below it; see `ROOMS`.
#:
#: Data flow from the first room to the last: parameters make points, a study lists them, the engine
#: runs them, the dataset gathers the runs, figures and claims read it, and the report shows all.
#: Laws, engines and papers come in as plug-ins do: no room imports them.
_BELOW = {
    "base": "",
    "parameters": "base",
    "study": "parameters",
    "engine": "parameters",
    "laws": "engine",
    "engines": "laws",
    "measures": "parameters",
    "dataset": "measures engine study",
    "surrogates": "dataset",
    "figures": "surrogates",
    "claims": "dataset",
    "verify": "figures",
    "papers": "claims",
    "report": "claims figures",
}

#: The rooms that each may import: those below it, and theirs.
ROOMS: dict[str, tuple[str, ...]] = {}
for _room, _below in _BELOW.items():
    _near = _below.split()
    ROOMS[_room] = tuple({*_near, *(far for near in _near for far in ROOMS[near])})

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
