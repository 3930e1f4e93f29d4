"""Runs of other studies in the same folder of results: what one study has run, none runs again.

There is no store beside the studies: the name of a run file is the id of its point, so the run
files of all studies are one. A run is taken by a second name for the same file, a hard link. That
is safe because whatever changes a run file or a state replaces it.
"""

import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from graphlib import TopologicalSorter
from pathlib import Path
from typing import NamedTuple

from sim.base.errors import InputError, count_text
from sim.base.files import date_back_readers, file_lock, temporary_folder
from sim.base.seals import is_damaged
from sim.engine.states import state_file, stored_samples
from sim.engine.stored_run import (
    Levels,
    has_enough,
    is_alike,
    length_of,
    read_amounts,
    read_origin_samples,
    read_parameters,
)
from sim.parameters import RUN_FILE, Parameters, amounts, covers


class SharedRun(NamedTuple):
    """A run file of another study that a point should have here.

    ``is_enough`` is true where it has all amounts of the point; else the run grows from it.
    """

    point: Parameters
    path: Path
    is_enough: bool


def find_runs(
    runs: Path, points: Mapping[str, Parameters], need: Callable[[str], Levels] = lambda _: None
) -> dict[str, SharedRun]:
    """Return what other studies have of those points that lack a large enough run file here.

    Of several run files that are large enough, one that holds a run of just the wanted length is
    preferred, then the largest. Where none is, it is the largest that a run here would pass
    through, if it saves time. A run file here is only replaced by one that holds all that it holds.
    Nothing is written. Files are not checked for damage; `take_runs` does.

    ``runs`` is the folder of the run files of a study; those of other studies are beside its
    parent. Points, and what a reduced run file must have of them here, are by id.
    """
    lacking = {
        key: point
        for key, point in points.items()
        if not has_enough(runs / f"{key}.nc", point, need(key))
    }
    files = _files_elsewhere(runs, {f"{key}.nc" for key in lacking})
    starts = {key: {point.start_from} & lacking.keys() for key, point in lacking.items()}
    shared: dict[str, SharedRun] = {}
    # What a point starts from comes first.
    for key in TopologicalSorter(starts).static_order() if files else ():
        paths, point = files.get(f"{key}.nc", []), lacking[key]
        if paths and point.start_from:
            paths = _from_same_end(paths, point.start_from, runs, shared)
        if best := _best(paths, runs / f"{key}.nc", point):
            shared[key] = best
    return shared


def describe(shared: Iterable[SharedRun]) -> str:
    """Return a line that says how many points other studies have; empty where there are none."""
    shared = list(shared)
    parts = []
    for is_enough, words in ((True, "not to be run"), (False, "from which runs here grow")):
        counts = Counter(run.path.parts[-3] for run in shared if run.is_enough == is_enough)
        if counts:
            names = ", ".join(f"{name} ({count:,})" for name, count in sorted(counts.items()))
            parts.append(
                f"{count_text(counts.total(), 'point')} in other studies, {words}: {names}"
            )
    return "; ".join(parts)


def take_runs(runs: Path, shared: Mapping[str, SharedRun]) -> set[str]:
    """Give run files of other studies, with their states, a name here; return ids of these points.

    Files are copied where no link is possible. A damaged file is not taken, and stays as it is. Nor
    is a file taken whose point is being run here.
    """
    taken = set()
    if shared:
        runs.mkdir(parents=True, exist_ok=True)
        with temporary_folder(runs / "taken") as folder:
            for key, run in shared.items():
                # What cannot be read is not taken, and what is locked is being made here.
                with suppress(OSError):
                    if _take(run, runs / f"{key}.nc", folder):
                        taken.add(key)
    if taken:
        date_back_readers(runs.parent)
    return taken


def _take(run: SharedRun, output: Path, folder: Path) -> bool:
    """Take a run file and its state, by way of a temporary folder; return whether it was whole."""
    new, new_state = folder / output.name, folder / state_file(output).name
    with file_lock(output, wait=False):
        # A run that grows writes its state first; so the state is never behind the run file.
        if not _fetch(run.path, new):
            return False
        if _fetch(state_file(run.path), new_state):
            here, there = (sum(stored_samples(path, run.point)) for path in (output, new))
            if there >= here:
                new_state.replace(state_file(output))
        new.replace(output)
    return True


def _fetch(source: Path, target: Path) -> bool:
    """Link a file to a new name, or copy it; return whether it is there and whole."""
    with suppress(FileNotFoundError):
        try:
            os.link(source.resolve(), target)
        except OSError:
            shutil.copy2(source, target)
        return not is_damaged(target)
    return False


def _files_elsewhere(runs: Path, names: set[str]) -> dict[str, list[Path]]:
    """Return the files of these names in other studies, each inode once, by name."""
    found: dict[str, dict[int, Path]] = {name: {} for name in names}
    with suppress(OSError):
        studies = sorted(runs.parent.parent.iterdir()) if names else []
        for study in (one for one in studies if one.name != runs.parent.name):
            # Folders that are no studies, or that are not ours to read.
            with suppress(OSError), os.scandir(study / runs.name) as entries:
                for entry in entries:
                    if entry.name in names and entry.is_file():
                        found[entry.name].setdefault(entry.stat().st_ino, Path(entry.path))
    return {name: list(paths.values()) for name, paths in found.items() if paths}


def _from_same_end(
    paths: Iterable[Path], start: str, runs: Path, shared: Mapping[str, SharedRun]
) -> list[Path]:
    """Return those run files that started from the same end of another run as a run here would.

    Snakemake must not take them for outdated, so they are not older than the other run.
    """
    origin = Path(start) if start.endswith(RUN_FILE) else runs / f"{start}.nc"
    if start in shared:
        if not shared[start].is_enough:
            return []
        origin = shared[start].path
    with suppress(OSError, InputError):
        samples, changed = stored_samples(origin, read_parameters(origin)), origin.stat().st_mtime
        return [
            path
            for path in paths
            if path.stat().st_mtime >= changed
            and (there := read_origin_samples(path))
            and samples
            and is_alike(there, samples)
        ]
    return []


def _best(paths: Iterable[Path], own: Path, point: Parameters) -> SharedRun | None:
    """Return the best of the run files of a point in other studies, if any is better than none."""
    wanted, held = amounts(point), read_amounts(own, point)
    here = sum(stored_samples(own, point)) if paths else 0
    best: tuple[tuple[bool, bool], Mapping[str, float], Path] | None = None
    for path in paths:
        with suppress(OSError):  # some are not ours to read
            there = read_amounts(path, point)
            if not there or (held and not covers(there, held)):
                continue
            is_enough = covers(there, wanted)
            if is_enough or _saves_time(path, there, here, held, point):
                rank = is_enough, is_enough and length_of(there) == length_of(wanted)
                if best is None or (rank, not covers(best[1], there)) > (best[0], False):
                    best = rank, there, path
    return SharedRun(point, best[2], best[0][0]) if best else None


def _saves_time(
    path: Path,
    there: Mapping[str, float],
    here: int,
    held: Mapping[str, float] | None,
    point: Parameters,
) -> bool:
    """True where a run that is too small has more than there is here, and nothing unwanted.

    ``there`` and ``held`` are the amounts of both; ``here`` counts the samples in the states here.
    """
    samples = sum(stored_samples(path, point))
    is_larger = samples > here or not held or not covers(held, there)
    return covers(amounts(point), there) and samples >= here and is_larger
