"""The rooms of the package: the rooms that each may import, and hashes of their code.

Data flow from the first room to the last: parameters make points, a study lists them, the engine
runs them, the dataset gathers the runs, figures and claims read it, and the report shows all.
"""

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

ROOMS: dict[str, tuple[str, ...]] = {
    "base": (),
    "parameters": ("base",),
    "study": ("parameters", "base"),
    "engine": ("parameters", "base"),
    "laws": ("engine", "parameters", "base"),
    "dataset": ("engine", "study", "parameters", "base"),
    "figures": ("dataset", "engine", "study", "parameters", "base"),
    "claims": ("dataset", "engine", "study", "parameters", "base"),
    "report": ("claims", "figures", "dataset", "engine", "study", "parameters", "base"),
}

#: Rooms whose edits invalidate no output: runs depend on the number of the numerics instead of the
#: engine's code, and each figure depends on its own entry of the catalogue.
UNTRACKED = ("engine", "study/catalogue")


@cache
def room_hash(package: Path, room: str) -> str:
    """Return a hash of the files of a room and its imports, those in `UNTRACKED` excluded.

    Parameters
    ----------
    package : Path
        Folder of the package.
    room : str
        One of `ROOMS`. The hash of the report includes the catalogue, which the report shows.
    """
    untracked = UNTRACKED[:1] if room == "report" else UNTRACKED
    return files_hash(
        path
        for name in (room, *ROOMS[room])
        for path in (package / name).rglob("*")
        if path.is_file()
        and "__pycache__" not in path.parts
        and not any(path.is_relative_to(package / other) for other in untracked)
    )


def files_hash(files: Iterable[Path]) -> str:
    """Return a hash of the names and contents of files; their folders do not matter."""
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:12]
