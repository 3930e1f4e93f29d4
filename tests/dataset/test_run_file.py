"""Summaries of run files, their amounts, and checks of those that points start from."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sim.__main__ import main
from sim.base.errors import InputError
from sim.dataset.build import build
from sim.engine.run import run_point
from sim.engine.stored_run import summary_of
from sim.parameters import amounts
from sim.parameters.variables import SCALARS
from sim.report.status import survey
from sim.study.load import load_study
from tests.engine_motion.points import belt_point
from tests.made.folder import Folder
from tests.made.netcdf import edit_file
from tests.made.processes import refusal
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
    line = refusal(capsys, "points", path)
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


GROWN = """\
study: grown
series:
  - name: beds
    system: belt
    base: {beads: 12, width: 5, transient: 1, %s}
    grid: {frequency: [20, 50]}
"""
SHORT, LONG = "average: 2, replicates: 1", "average: 4, replicates: 2"


def run_study(folder, *lengths) -> xr.Dataset:
    """Run a study with several lengths in turn; return the dataset of the last."""
    path = folder / "grown.yaml"
    for length in lengths:
        path.write_text(GROWN % length)
        for point in load_study(path, folder).points.values():
            (folder / "grown" / "runs").mkdir(parents=True, exist_ok=True)
            run_point(point.parameters, folder / "grown" / "runs" / f"{point.id}.nc", quiet=True)
        output = build(path, folder)
    return xr.load_dataset(output)


def test_replicates_that_are_not_asked_for_are_left_out_and_a_longer_run_is_told(tmp_path):
    grown = run_study(tmp_path, SHORT, LONG)
    assert grown.sizes["replicate"] == 2 and (grown["average"] == 4).all()
    study = load_study(tmp_path / "grown.yaml", tmp_path)
    assert survey(study, tmp_path).is_over
    less = run_study(tmp_path, SHORT)
    np.testing.assert_array_equal(less["velocity"], grown["velocity"][:, :1])
    assert all("runs longer than is asked for" in text for text in less["caveat"].values)
    assert survey(load_study(tmp_path / "grown.yaml", tmp_path), tmp_path).is_over


def test_a_point_that_is_to_grow_is_not_read(tmp_path):
    run_study(tmp_path, SHORT)
    (tmp_path / "grown.yaml").write_text(GROWN % LONG)
    with pytest.raises(InputError, match=r"\.nc: holds .*average 2 of .*average 4") as error:
        build(tmp_path / "grown.yaml", tmp_path)
    assert "(and 1 more)" in str(error.value)
    assert len(list((tmp_path / "grown" / "runs").glob("*.nc"))) == 2


def test_a_summary_is_that_of_what_is_wanted(tmp_path):
    run_study(tmp_path, SHORT, LONG)
    for length in (SHORT, LONG):
        (tmp_path / "grown.yaml").write_text(GROWN % length)
        for point in load_study(tmp_path / "grown.yaml", tmp_path).points.values():
            path = tmp_path / "grown" / "runs" / f"{point.id}.nc"
            scalars = summary_of(path, amounts(point.parameters)).scalars
            with netCDF4.Dataset(path) as file:
                expected = file["velocity"][: point.parameters.replicates]
            np.testing.assert_array_equal(scalars["velocity"], expected)
