"""A made-up study up to its figures, made once for all tests of a process."""

import shutil
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from sim.dataset.build import build
from sim.figures.render import draw
from sim.study.load import load_study
from tests.made.runs import make_study


@cache
def _made() -> TemporaryDirectory:
    folder = TemporaryDirectory(prefix="talus-made-")
    study_path, results = make_study(Path(folder.name))
    dataset = build(study_path, results)
    for name in load_study(study_path, results).figures:
        draw(name, dataset, results / "made" / "figures")
    return folder


def make_figures(folder: Path) -> tuple[Path, Path]:
    """Copy the study of `make_study` with its dataset and figures; return file and results."""
    shutil.copytree(_made().name, folder, dirs_exist_ok=True)
    return folder / "made.yaml", folder / "results"
