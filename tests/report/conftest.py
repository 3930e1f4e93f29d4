"""A study that has run to its end, as made up."""

import shutil
from pathlib import Path

import pytest

from sim.study.load import load_study
from tests.made.figures import make_figures
from tests.made.report import write_claims


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """A folder with a made-up study and everything that a workflow leaves."""
    root = tmp_path_factory.mktemp("whole")
    study, results = make_figures(root)
    points = list(load_study(study, results).points)
    write_claims(results / "made" / "claims.json", points)
    (results / "made" / "report.html").write_text("report")
    (results / "made" / "figures" / "old.svg").write_text("old")
    return root


@pytest.fixture
def finished(whole, tmp_path):
    """The study file and the folder of results of a copy of it."""
    shutil.copytree(whole, tmp_path, dirs_exist_ok=True)
    return tmp_path / "made.yaml", tmp_path / "results"
