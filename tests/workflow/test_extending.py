"""Plug-ins in a workflow: loaded in every job; an edit reruns what depends on them."""

import json
import shutil
from pathlib import Path

import pytest
import xarray as xr

from tests.made.processes import ROOT
from tests.made.project import planned_jobs, snakemake

STUDY = """\
study: own
pages: true
plugins: [base_slip.py, boxes.py, steeper.py]
defaults:
  chute: {depth: 1.5, cell: 4, transient: 10, average: 20}
series:
  - {name: frictions, system: chute, grid: {friction: [0.4, 0.5]}}
plots:
  - {name: slip, x: friction, y: base_slip}
  - {name: spread, kind: boxes, x: friction, y: velocity}
"""

#: The same with a contact law, which takes minutes to compile.
WITH_LAW = (
    STUDY.replace("plugins: [", "plugins: [hertz_mindlin.py, ")
    .replace("chute: {", "chute: {law: hertz_mindlin, diameter_spread: 0.3, ")
    .replace("friction: [0.4, 0.5]", "youngs_modulus: [1.0e+6, 2.0e+6]")
    .replace("x: friction", "x: youngs_modulus")
)
NAME = "own.yaml"

#: Jobs that an edit entails.
JOBS_OF_DATASET = {"dataset": 1, "figures": 1, "claims": 1, "report": 1}
EDITS = {
    NAME: {"report": 1},
    "steeper.py": {"claims": 1, "report": 1},
    "boxes.py": {"figures": 1, "report": 1},
    "base_slip.py": JOBS_OF_DATASET,
}
EDITS_OF_LAW = {"hertz_mindlin.py": {"batch": 1, "pages": 1} | JOBS_OF_DATASET}


def run(text: str, tree: Path) -> Path:
    """Run a study to its end in a folder, and return its folder of results."""
    for path in (ROOT / "docs" / "examples").glob("*.py"):
        shutil.copy(path, tree)
    (tree / NAME).write_text(text)
    process = snakemake(tree, study=NAME)
    assert process.returncode == 0, process.stderr
    assert "base_slip.py" in process.stderr and "observable base_slip" in process.stderr
    return tree / "results" / "own"


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a folder in which the study has run to its end."""
    tree = tmp_path_factory.mktemp("tree")
    run(STUDY, tree)
    return tree


def test_every_job_has_the_plugins_that_it_needs(tree):
    results = tree / "results" / "own"
    with xr.open_dataset(results / "dataset.nc") as dataset:
        assert (dataset["status"] == "completed").all()
        assert (dataset["base_slip"] > 0).all()
    claims = json.loads((results / "claims.json").read_text())["claims"]
    assert claims[-1]["id"] == "steeper_is_faster"
    assert (results / "figures" / "spread.svg").is_file()
    assert "base_slip.py" in (results / "report.html").read_text()


def jobs_after_edit(tree: Path, name: str) -> dict[str, int]:
    """Return the jobs that an edit entails; the edit is undone."""
    path = tree / name
    before = path.read_text()
    try:
        path.write_text(before + "# edited\n")
        return planned_jobs(tree, study=NAME)
    finally:
        path.write_text(before)


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_of_a_plugin_makes_old_what_depends_on_it(tree, name):
    assert jobs_after_edit(tree, name) == EDITS[name]


@pytest.mark.long
def test_a_law_goes_the_whole_way(tmp_path):
    results = run(WITH_LAW, tmp_path)
    with xr.open_dataset(results / "dataset.nc") as dataset:
        assert (dataset["status"] == "completed").all()
        assert all(name.startswith("hertz_mindlin.") for name in dataset["law"].values)
        assert dataset["youngs_modulus"].values.tolist() == [1e6, 2e6]
        assert dataset["youngs_modulus"].attrs["units"] == "Pa"
        assert (dataset["missing_energy"] < 0.02).all()
        assert (abs(dataset["normal_balance"] - 1) < 0.1).all()
    assert "hertz_mindlin.py" in (results / "report.html").read_text()
    for page in (results / "pages").iterdir():
        assert "hertz_mindlin" in page.read_text()
    for name, jobs in (EDITS | EDITS_OF_LAW).items():
        assert jobs_after_edit(tmp_path, name) == jobs
