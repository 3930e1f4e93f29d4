"""The made-up study up to its figures."""

from pathlib import Path

from sim.dataset.build import build
from sim.figures.render import draw
from sim.study.load import load_study
from tests.made.once import once
from tests.made.runs import make_study


@once
def make_figures(folder: Path) -> tuple[Path, Path]:
    """Make the study of `make_study` with its dataset and figures; return file and results."""
    study_path, results = make_study(folder)
    dataset = build(study_path, results)
    for name in load_study(study_path, results).figures:
        draw(name, dataset, results / "made" / "figures")
    return study_path, results
