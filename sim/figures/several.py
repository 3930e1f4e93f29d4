"""The figures of a study in few processes, those left out that are as they would be drawn."""

import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from sim.figures.drawn import as_drawn, read_drawn, write_drawn
from sim.figures.render import entry, render
from sim.study.load import load_study


def draw_several(
    names: Sequence[str],
    dataset_path: Path,
    out_folder: Path,
    processes: int = 1,
    code: str = "",
    study_path: Path | None = None,
) -> None:
    """Draw figures of a study side by side; one that cannot be drawn keeps no other from it.

    Parameters
    ----------
    names : sequence of str
        Names of `FIGURES`, or of the study's own plots.
    dataset_path : Path
        The study's ``dataset.nc``.
    out_folder : Path
        Folder for the files; made if absent.
    processes : int
        How many draw side by side.
    code : str
        Stands for the code that draws. With it, figures are left out whose files are still those
        that it has drawn from this dataset and their entry of the catalogue.
    study_path : Path, optional
        The study file, which says what its own plots are.

    Raises
    ------
    InputError
        For an unknown figure, a missing dataset, or one without points for a figure; of several
        problems all but the first are told on standard error.
    """
    plots = load_study(study_path, None).plots if study_path else None
    specs = {name: entry(name, plots) for name in names}
    drawn = read_drawn(out_folder) if code else {}
    wanted = [
        name
        for name, spec in specs.items()
        if name not in drawn or drawn[name] != as_drawn(spec, dataset_path, out_folder, code)
    ]
    forks = get_context("fork")
    with ProcessPoolExecutor(max(1, min(processes, len(wanted))), forks) as pool:
        found = {
            name: pool.submit(render, specs[name], dataset_path, out_folder) for name in wanted
        }
        problems = {name: each.exception() for name, each in found.items()}
    if code and wanted and out_folder.is_dir():
        for name, problem in problems.items():
            if not problem and (fresh := as_drawn(specs[name], dataset_path, out_folder, code)):
                drawn[name] = fresh
        write_drawn(out_folder, drawn)
    if told := [problem for problem in problems.values() if problem]:
        for problem in told[1:]:
            print(f"error: {problem}", file=sys.stderr)
        raise told[0]
