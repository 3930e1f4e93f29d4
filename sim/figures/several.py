"""Draw the figures of a study in parallel, and skip those that are up to date."""

import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from sim.figures.figure_records import current_record, read_records, write_records
from sim.figures.render import find_spec, render
from sim.study.load import load_study


def draw_figures(
    names: Sequence[str],
    dataset_path: Path,
    out_folder: Path,
    processes: int = 1,
    code: str = "",
    study_path: Path | None = None,
) -> None:
    """Draw figures of a study in parallel; a failed figure does not stop the others.

    Parameters
    ----------
    names : sequence of str
        Names of `FIGURES`, or of the study's own plots.
    dataset_path : Path
        The study's ``dataset.nc``.
    out_folder : Path
        Folder for the files; made if absent.
    processes : int
        Number of processes.
    code : str
        Hash of the code that draws. If given, figures are skipped whose files are unchanged since
        this code drew them from this dataset and their entry of the catalogue.
    study_path : Path, optional
        The study file, which defines the study's own plots.

    Raises
    ------
    InputError
        For an unknown figure, a missing dataset, or one without points for a figure. Of several
        errors the first is raised, and the others are printed on standard error.
    """
    plots = load_study(study_path, None).plots if study_path else None
    specs = {name: find_spec(name, plots) for name in names}
    records = read_records(out_folder) if code else {}
    outdated = [
        name
        for name, spec in specs.items()
        if name not in records
        or records[name] != current_record(spec, dataset_path, out_folder, code)
    ]
    forks = get_context("fork")
    with ProcessPoolExecutor(max(1, min(processes, len(outdated))), forks) as pool:
        futures = {
            name: pool.submit(render, specs[name], dataset_path, out_folder) for name in outdated
        }
        problems = {name: future.exception() for name, future in futures.items()}
    if code and outdated and out_folder.is_dir():
        for name, problem in problems.items():
            if not problem and (
                record := current_record(specs[name], dataset_path, out_folder, code)
            ):
                records[name] = record
        write_records(out_folder, records)
    if failures := [problem for problem in problems.values() if problem]:
        for problem in failures[1:]:
            print(f"error: {problem}", file=sys.stderr)
        raise failures[0]
