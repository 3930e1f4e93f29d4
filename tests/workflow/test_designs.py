"""A design in the workflow: it grows, and what has run is kept."""

import pytest

from sim.report.points import show
from sim.study.load import load_study
from tests.made.project import bare_folder, snakemake

STUDY = "spread.yaml"


@pytest.mark.long
def test_a_design_grows_from_32_to_64_points_without_a_run_lost(tmp_path):
    tree = bare_folder(tmp_path, STUDY)
    study, runs = tree / STUDY, tree / "results" / "spread" / "runs"
    before = load_study(study, None).points.keys()
    process = snakemake(tree, "runs", study=STUDY)
    assert process.returncode == 0, process.stderr
    files = {path.stem: path.read_bytes() for path in runs.glob("*.nc")}
    assert files.keys() == before

    study.write_text(study.read_text().replace("points: 32", "points: 64"))
    after = load_study(study, None).points.keys()
    assert before < after
    assert len(after) == 64
    text = show(study, "table", results=tree / "results")
    assert f"32 of 64 points have been run in {tree}/results/spread; core time of" in text
    process = snakemake(tree, "runs", study=STUDY)
    assert process.returncode == 0, process.stderr
    grown = {path.stem: path.read_bytes() for path in runs.glob("*.nc")}
    assert grown.keys() == after
    assert {name: grown[name] for name in files} == files
