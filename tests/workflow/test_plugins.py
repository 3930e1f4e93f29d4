"""Plug-ins in a workflow, among them a stranger's paper, as docs/extending.md tells.

They are loaded in every job; an edit reruns what depends on them.
"""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.claims.claim import claims
from sim.study.command import init
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study
from sim.study.papers import papers
from tests.made.processes import ROOT, restore_plugins
from tests.made.project import planned_jobs, snakemake
from tests.made.runs import HEIGHTS, write_run

EXAMPLES, STUDY, CLAIM = ROOT / "docs" / "examples", "incline.yaml", "incline_steeper"

#: What other plug-ins add to the study of the paper.
PLOTS = """\
plots:
  - {name: slip, x: angle, y: base_slip}
  - {name: spread, kind: boxes, x: angle, y: velocity}
"""

#: A study with a contact law, which takes minutes to compile.
LAW_STUDY = """\
study: incline
plugins: [hertz_mindlin.py, base_slip.py, boxes.py, steeper.py]
defaults:
  chute: {law: hertz_mindlin, diameter_spread: 0.3, depth: 1.5, cell: 4, transient: 10, average: 20}
series:
  - {name: moduli, system: chute, grid: {grain_modulus: [1.0e+6, 2.0e+6]}}
""" + PLOTS.replace("angle", "grain_modulus")

#: Jobs that an edit of a file entails.
JUDGED = {"claims": 1, "report": 1}
GATHERED = {"dataset": 1, "figures": 1, **JUDGED}
EDITS = {
    STUDY: {"report": 1},
    "steeper.py": JUDGED,
    "boxes.py": {"figures": 1, "report": 1},
    "base_slip.py": GATHERED,
}
EDITS_OF_PAPER = {"incline/judges.py": JUDGED, "incline/claims.yaml": JUDGED}
EDITS_OF_LAW = {"hertz_mindlin.py": {"batch": 1} | GATHERED}


def bring_paper(folder: Path) -> str:
    """Write a paper and its study into a folder; return the text of the study."""
    init(folder, "", "incline")
    return (folder / STUDY).read_text(encoding="utf-8")


def run(tree: Path) -> Path:
    """Run the study of a folder with the plug-ins of the examples; return its results."""
    process = snakemake(tree, study=STUDY)
    assert process.returncode == 0, process.stderr
    assert "base_slip.py" in process.stderr and "observable base_slip" in process.stderr
    return tree / "results" / "incline"


def bring_plugins(tree: Path, text: str) -> None:
    for path in EXAMPLES.glob("*.py"):
        shutil.copy(path, tree)
    (tree / STUDY).write_text(text)


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a folder in which the study of the paper, with more plug-ins, has come to its end.

    Its runs are made up.
    """
    tree = tmp_path_factory.mktemp("paper")
    plugins = "plugins: [incline, base_slip.py, boxes.py, steeper.py]"
    bring_plugins(tree, bring_paper(tree).replace("plugins: [incline]", plugins) + PLOTS)
    with (tree / "incline" / "figures.yaml").open("a") as file:
        file.write("    beside: {label: measured, points: [[16, 0.2]]}\n")
    with restore_plugins():
        points = load_study(tree / STUDY, tree / "results").points.values()
    for one in (point.parameters for point in points):
        velocity = 0.01 * one.angle * np.array([0.99, 0.995, 1.005, 1.01])
        packing = {"packing_profile": (("replicate", "height"), np.full((4, HEIGHTS), 0.6))}
        write_run(tree / "results" / "incline" / "runs", one, velocity, arrays=packing)
    run(tree)
    return tree


def test_the_paper_gets_figure_verdict_table_and_report(tree):
    results = tree / "results" / "incline"
    (claim,) = [
        one
        for one in json.loads((results / "claims.json").read_text())["claims"]
        if one["paper"] == "incline"
    ]
    assert claim["id"] == CLAIM and claim["verdict"] == "reproduced"
    assert claim["criterion"].startswith("V of steady flows rises over at least 3 angles (Jonckh")
    assert CLAIM in (results / "claims.csv").read_text()
    caption = (results / "figures" / "incline_velocity.caption.txt").read_text()
    assert caption.startswith("Author et al. (2000), Fig. 1. Mean velocity V")
    lines = (results / "figures" / "incline_velocity.csv").read_text().splitlines()
    assert len(lines) == 5 and lines[-1].startswith("measured,") and "measured" in caption
    report = (results / "report.html").read_text()
    assert "Author et al. (2000), Fig. 1" in report
    assert f'id="claim-{CLAIM}" data-paper="incline"' in report
    assert "<p>Author et al. (2000), chute: n = 1.24, μ = 0.4, e = 0.85</p>" in report
    assert '<option value="incline">Author et al.</option>' in report
    heads = re.search(
        r"Verdicts on the statements on flows of each paper.*?</thead>", report, re.DOTALL
    )
    assert re.findall(r'class="number">(.*?)<', heads[0]) == ["Author et al."]


def test_every_job_has_the_plugins_that_it_needs(tree):
    results = tree / "results" / "incline"
    with xr.open_dataset(results / "dataset.nc") as dataset:
        assert (dataset["status"] == "completed").all()
        assert (dataset["base_slip"] > 0).all()
    judged = json.loads((results / "claims.json").read_text())["claims"]
    assert "steeper_is_faster" in {claim["id"] for claim in judged}
    assert (results / "figures" / "spread.svg").is_file()
    assert "base_slip.py" in (results / "report.html").read_text()


def jobs_after_edit(tree: Path, name: str) -> dict[str, int]:
    """Return the jobs that an edit entails; the edit is undone."""
    path = tree / name
    before = path.read_text()
    try:
        path.write_text(before + "# edited\n")
        return planned_jobs(tree, study=STUDY)
    finally:
        path.write_text(before)


@pytest.mark.parametrize(("name", "jobs"), (EDITS | EDITS_OF_PAPER).items())
def test_an_edit_makes_old_what_depends_on_it_and_no_run(tree, name, jobs):
    assert jobs_after_edit(tree, name) == jobs


@pytest.mark.long
def test_a_law_goes_the_whole_way(tmp_path):
    bring_plugins(tmp_path, LAW_STUDY)
    results = run(tmp_path)
    with xr.open_dataset(results / "dataset.nc") as dataset:
        assert (dataset["status"] == "completed").all()
        assert all(name.startswith("hertz_mindlin.") for name in dataset["law"].values)
        assert dataset["grain_modulus"].values.tolist() == [1e6, 2e6]
        assert dataset["grain_modulus"].attrs["units"] == "Pa"
        assert (dataset["missing_energy"] < 0.02).all()
        assert (abs(dataset["normal_balance"] - 1) < 0.1).all()
    assert "hertz_mindlin.py" in (results / "report.html").read_text()
    for name, jobs in (EDITS | EDITS_OF_LAW).items():
        assert jobs_after_edit(tmp_path, name) == jobs


def test_the_paper_is_loaded_beside_those_that_ship(tmp_path):
    bring_paper(tmp_path)
    with restore_plugins():
        load_study(tmp_path / STUDY, None)
        assert list(papers()) == ["walton", "gallas", "silbert", "incline"]
        assert FIGURES["incline_velocity"].kind == "curves"
        assert [claim.id for claim in claims()][-1] == CLAIM
    assert list(papers()) == ["walton", "gallas", "silbert"]
    assert "incline_velocity" not in FIGURES and claims()[-1].id == "S10"
