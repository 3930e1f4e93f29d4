"""The summary of a run, from the end of its file and from the whole file."""

import netCDF4
import numpy as np
import pytest

from sim.dataset.boundary_side import side_of_run
from sim.dataset.run_file import summary_of
from sim.engine.run import run_point
from sim.parameters.variables import SCALARS
from tests.engine_motion.points import belt_point
from tests.made.folder import Folder
from tests.made.netcdf import edit_file

POINT = belt_point(beads=20, width=5, transient=1, average=3, replicates=2)


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
