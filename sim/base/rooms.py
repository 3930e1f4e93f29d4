"""The rooms of the package: which there are, which others each may import, hashes of their code.

Read upwards it is the way of the data: parameters make points, a study lists them, the engine runs
them, the dataset gathers the runs, figures and claims look at it, and the report shows it all.
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
    "dataset": ("engine", "study", "parameters", "base"),
    "figures": ("dataset", "engine", "study", "parameters", "base"),
    "claims": ("dataset", "engine", "study", "parameters", "base"),
    "report": ("claims", "figures", "dataset", "engine", "study", "parameters", "base"),
}

#: Rooms whose edits make nothing old by themselves: the number of the numerics speaks for the
#: engine, and each figure names its own entry of the catalogue.
NOT_FOLLOWED = ("engine", "study/catalogue")


@cache
def room_hash(package: Path, room: str) -> str:
    """Return a hash of all files of a room and of those that it may import, but of the engine.

    Parameters
    ----------
    package : Path
        Folder of the package.
    room : str
        One of `ROOMS`. The report, which shows it, also follows the catalogue.
    """
    passed_over = NOT_FOLLOWED[:1] if room == "report" else NOT_FOLLOWED
    return files_hash(
        path
        for name in (room, *ROOMS[room])
        for path in (package / name).rglob("*")
        if path.is_file()
        and "__pycache__" not in path.parts
        and not any(path.is_relative_to(package / other) for other in passed_over)
    )


def files_hash(files: Iterable[Path]) -> str:
    """Return a hash of the names and contents of files, wherever they lie."""
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:12]
