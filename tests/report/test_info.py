"""`python -m sim info`: a summary of a run, and the point that makes it again."""

import re

import pytest
import yaml

from sim.__main__ import main
from sim.base.seals import seal
from sim.parameters import BeltParameters, ChuteParameters, load_point
from sim.report.info import describe
from tests.made.figures import make_built_study
from tests.made.netcdf import edit_file
from tests.made.processes import refusal
from tests.made.runs import FAILURE, write_run

POINTS = [
    ChuteParameters(depth=2.5, friction=0.3, friction_plane=0.5, orientations=False, replicates=2),
    BeltParameters(frequency=62.5, integrator="verlet", seed=7),
]


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.system)
def test_the_point_reproduces_all_parameters(tmp_path, point):
    text = describe(write_run(tmp_path, point), as_point=True)
    (tmp_path / "again.yaml").write_text(text)
    assert load_point(tmp_path / "again.yaml") == point
    assert next(iter(yaml.safe_load(text))) == "system"


def test_the_summary_names_parameters_results_and_provenance(tmp_path, capsys):
    path = write_run(tmp_path, POINTS[0], [0.5, 0.25], failed=[1])
    assert main(["info", str(path)]) == 0
    text = capsys.readouterr().out
    assert path.stem in text
    assert re.search(r"friction_plane +0\.5\n", text)
    assert re.search(r" velocity \(m s-1\) +0\.5 \| nan\n", text)
    assert f"| {FAILURE}" in text
    assert "source_hash" in text


@pytest.mark.parametrize("content", [None, b"", b"no netCDF"])
def test_a_file_that_is_no_run_gives_one_line(tmp_path, capsys, content):
    path = tmp_path / "odd.nc"
    if content is not None:
        path.write_bytes(content)
    assert "odd.nc" in refusal(capsys, "info", path)


def test_a_dataset_is_called_one(tmp_path, capsys):
    path = make_built_study(tmp_path)[1] / "made" / "dataset.nc"
    line = refusal(capsys, "info", path)
    assert line == f"error: {path}: the dataset of study made, not a run file"
    assert path.exists()


def test_nothing_of_a_run_file_from_elsewhere_moves_the_cursor(tmp_path, capsys):
    path = write_run(tmp_path, ChuteParameters(), 0.5)
    with edit_file(path) as file:
        file.command = "a\x1b[31mX\u202eb\x07"
    # As whoever has made it may have sealed it.
    seal(path)
    assert main(["info", str(path)]) == 0
    out = capsys.readouterr().out
    assert r"a\x1b[31mX\u202eb\x07" in out and "\x1b" not in out and "\u202e" not in out
