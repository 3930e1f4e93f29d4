"""Summaries of run files, and checks of those that points start from before any job runs."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest

from sim.__main__ import main
from sim.dataset.build import build
from sim.dataset.rounds import side_of_run
from sim.dataset.run_file import summary_of
from sim.engine.run import run_point
from sim.parameters.variables import SCALARS
from tests.engine_motion.points import belt_point
from tests.made.folder import Folder
from tests.made.netcdf import edit_file
from tests.made.project import snakemake

STUDY = """\
study: made
series: [{name: a, system: chute, base: {depth: 2, replicates: 2}, cases: %s}]
"""

POINT = belt_point(beads=20, width=5, transient=1, average=3, replicates=2)


@pytest.fixture
def source(tmp_path) -> Folder:
    """A study with a run of two replicates and its dataset."""
    (tmp_path / "source").mkdir()
    made = Folder(tmp_path / "source", STUDY % "[{}]")
    made.finish(made.ids[0])
    build(made.file, made.results)
    return made


def study(folder: Path, start: Path, more: str = "") -> Path:
    path = folder / "s.yaml"
    path.write_text(STUDY % f"[{{start_from: {start}, angle: 20{more}}}]")
    return path


def test_a_start_file_that_fits_is_accepted(source, tmp_path, capsys):
    (start,) = source.runs.glob("*.nc")
    assert main(["points", str(study(tmp_path, start))]) == 0


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (", depth: 3", "allowed: a run with depth = 3.0"),
        (", replicates: 3", "allowed: a run of 3 replicates or more"),
        ("dataset.nc", "the dataset of study made, not a run file"),
        ("noise.nc", "noise.nc: damaged or not a run file"),
    ],
)
def test_one_that_does_not_fit_is_refused_at_once(source, tmp_path, more, said, capsys):
    (start,) = source.runs.glob("*.nc")
    if more == "dataset.nc":
        start, more = source.results / "made" / more, ""
    elif more == "noise.nc":
        start, more = tmp_path / more, ""
        start.write_bytes(bytes(range(256)) * 10)
    path = study(tmp_path, start, more)
    assert main(["points", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {path}: start_from: ") and said in line
    assert start.exists()


def test_the_workflow_refuses_it_before_any_job(source, tmp_path):
    path = study(tmp_path, source.results / "made" / "dataset.nc")
    done = snakemake(tmp_path, "runs", study=path.name)
    assert done.returncode == 2
    assert "error: s.yaml: start_from: " in done.stderr and "Job stats" not in done.stderr


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.nc"
    assert run_point(POINT, path, quiet=True) == 0
    return path


def test_the_end_of_a_file_tells_what_opening_it_does(path, tmp_path):
    summary = summary_of(path)
    other = tmp_path / "run.nc"
    other.write_bytes(path.read_bytes())
    with edit_file(other) as file:
        file.comment = "now its end says nothing"
    reopened = summary_of(other)
    assert summary.attrs | {"comment": reopened.attrs["comment"]} == reopened.attrs
    assert summary.scalars.keys() == reopened.scalars.keys() <= SCALARS.keys()
    for name, values in summary.scalars.items():
        np.testing.assert_array_equal(values, reopened.scalars[name])


def test_run_files_are_not_opened_to_see_how_they_ended(tmp_path, monkeypatch):
    folder = Folder(tmp_path)
    first, second, *_ = folder.ids
    point = folder.study.points[first].parameters
    path = folder.finish(first)
    folder.finish(second, failed=[0])
    monkeypatch.setattr(netCDF4, "Dataset", None)
    assert folder.survey().counts["done"] == folder.survey().counts["failed"] == 1
    assert side_of_run(path, "flow", point) == "flowing"
