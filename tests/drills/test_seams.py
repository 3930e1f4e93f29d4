"""A study is killed once after every file that it names or removes; the same commands end well."""

import os
from pathlib import Path

import pytest

from sim.figures.pictures import RECORD_FILE
from tests.drills.test_faults import files, same
from tests.made.faults import Seams
from tests.made.processes import ROOT, program

STUDY = """\
study: seams
title: "Speed {v_x} of {beads}"
defaults:
  belt: {beads: 10, width: 5, steps_per_cycle: 1000, transient: 1, average: 3, replicates: 2}
series:
  - name: wide
    system: belt
    design: {kind: sobol, points: 4, over: {frequency: [30, 60]}}
surrogate:
  - name: speed
    series: wide
    observable: velocity
    regimes: [steady, accelerating, slowing, arrested, mixed, undetermined]
boundaries:
  - {name: onset, system: belt, of: transport, along: frequency, range: [20, 60], tolerance: 15}
decide: {precision: 0.5, budget: 0.001}
"""

#: Commands from a study file to a publication and a dataset that another folder adopts.
COMMANDS = (
    ("study", "seams.yaml", "--cores", "2"),
    ("decide", "seams.yaml", "--cores", "2"),
    ("publish", "seams.yaml", "--to", "published"),
    ("job", "adopt", "seams.yaml", "published/seams/dataset.nc"),
)


def folder_of(tree: Path) -> Path:
    """Make a folder with the study, and return it."""
    tree.mkdir()
    (tree / "seams.yaml").write_text(STUDY)
    return tree


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Path:
    tree = folder_of(tmp_path_factory.mktemp("seams") / "undisturbed")
    for words in COMMANDS:
        done = program(*words, cwd=tree, env=os.environ | {"PYTHONPATH": str(ROOT)})
        assert done.returncode == 0, done.stdout + done.stderr
    return tree


@pytest.mark.long
@pytest.mark.parametrize("alone", [False, True], ids=["all processes", "one process"])
def test_after_a_kill_at_any_seam_the_same_command_ends_well(alone, undisturbed, tmp_path):
    tree = folder_of(tmp_path / "killed")
    seams = Seams(tree, tmp_path, alone=alone)
    for words in COMMANDS:
        seams.run(*words)
    print(f"{len(seams.names)} kills of {'one process' if alone else 'all processes'}")
    assert not list(tree.rglob("*.damaged*"))
    results = {Path("results"), Path("published")}
    there, expected = (
        {one for one in files(folder) if one.parts[0] in map(str, results)}
        for folder in (tree, undisturbed)
    )
    assert there == expected
    kinds = (".nc", ".json", ".csv", ".svg", ".txt")
    for path in there:
        if path.suffix in kinds and path.name not in (RECORD_FILE, "provenance.json"):
            assert same(tree / path, undisturbed / path), path
