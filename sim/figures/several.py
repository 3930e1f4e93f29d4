"""The figures of a study in few processes, those left out that are as they would be drawn."""

import hashlib
import json
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from sim.base.files import replacing
from sim.figures.render import draw, entry
from sim.study.catalogue import FIGURES

#: File beside the figures with a hash of each: of what it was drawn from, and of its files.
DRAWN = ".drawn.json"

#: Bytes at the end of a dataset that tell it from others, its seal among them.
TAIL = 128


def draw_several(
    names: Sequence[str],
    dataset_path: Path,
    out_folder: Path,
    processes: int = 1,
    code: str = "",
) -> None:
    """Draw figures of a study side by side; one that cannot be drawn keeps no other from it.

    Parameters
    ----------
    names : sequence of str
        Names of `FIGURES`.
    dataset_path : Path
        The study's ``dataset.nc``.
    out_folder : Path
        Folder for the files; made if absent.
    processes : int
        How many draw side by side.
    code : str
        Stands for the code that draws. With it, figures are left out whose files are still those
        that it has drawn from this dataset and their entry of the catalogue.

    Raises
    ------
    InputError
        For an unknown figure, a missing dataset, or one without points for a figure; of several
        problems all but the first are told on standard error.
    """
    for name in names:
        entry(name)
    drawn = _read(out_folder / DRAWN) if code else {}
    wanted = [
        name
        for name in names
        if not code or drawn.get(name) != _state(name, dataset_path, out_folder, code)
    ]
    forks = get_context("fork")
    with ProcessPoolExecutor(max(1, min(processes, len(wanted))), forks) as pool:
        found = {name: pool.submit(draw, name, dataset_path, out_folder) for name in wanted}
        problems = {name: each.exception() for name, each in found.items()}
    if code and wanted and out_folder.is_dir():
        fresh = [name for name, problem in problems.items() if not problem]
        drawn |= {name: _state(name, dataset_path, out_folder, code) for name in fresh}
        with replacing(out_folder / DRAWN) as temporary:
            temporary.write_text(json.dumps(drawn, indent=1), encoding="utf-8")
    if told := [problem for problem in problems.values() if problem]:
        for problem in told[1:]:
            print(f"error: {problem}", file=sys.stderr)
        raise told[0]


def _read(path: Path) -> dict[str, str]:
    """Return what a file says of the figures drawn before, nothing if it says nothing."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _state(name: str, dataset_path: Path, folder: Path, code: str) -> str:
    """Return a hash of what a figure is drawn from and of its files; none without all of them."""
    digest = hashlib.sha256(f"{code} {FIGURES[name]!r}".encode())
    try:
        with dataset_path.open("rb") as file:
            file.seek(max(0, dataset_path.stat().st_size - TAIL))
            digest.update(file.read())
        for suffix in FIGURES[name].suffixes:
            digest.update((folder / f"{name}{suffix}").read_bytes())
    except OSError:
        return ""
    return digest.hexdigest()
