"""The made-up studies up to their datasets and figures."""

from pathlib import Path

from sim.dataset.build import build
from sim.figures.render import draw_figures
from sim.study.load import load_study
from tests.made.once import once
from tests.made.runs import make_regimes, make_study


@once
def make_built_study(folder: Path) -> tuple[Path, Path]:
    """Make the study of `make_study` with its dataset; return study file and results."""
    study_path, results = make_study(folder)
    build(study_path, results)
    return study_path, results


@once
def make_built_regimes(folder: Path) -> tuple[Path, Path]:
    """Make the study of `make_regimes` with its dataset; return study file and results."""
    study_path, results = make_regimes(folder)
    build(study_path, results)
    return study_path, results


@once
def make_figures(folder: Path) -> tuple[Path, Path]:
    """Make the study of `make_study` with its dataset and figures; return file and results."""
    study_path, results = make_built_study(folder)
    names = list(load_study(study_path, results).figures)
    draw_figures(names, results / "made" / "dataset.nc", results / "made" / "figures", code="made")
    return study_path, results
