"""A dataset has the amounts of the study, even where run files hold more."""

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.dataset.build import build
from sim.dataset.run_file import summary_of
from sim.engine.run import run_point
from sim.parameters import amounts
from sim.report.status import survey
from sim.study.load import load_study
from tests.golden import CLOCK

STUDY = """\
study: grown
series:
  - name: beds
    system: belt
    base: {beads: 12, width: 5, transient: 1, %s}
    grid: {frequency: [20, 50]}
"""
SHORT, LONG = "average: 2, replicates: 1", "average: 4, replicates: 2"


@pytest.fixture(scope="module")
def short_dataset(tmp_path_factory) -> xr.Dataset:
    """The dataset of the short study, whose runs were never longer."""
    return run_study(tmp_path_factory.mktemp("short"), SHORT)


def run_study(folder, *lengths) -> xr.Dataset:
    """Run a study with several lengths in turn; return the dataset of the last."""
    path = folder / "grown.yaml"
    for length in lengths:
        path.write_text(STUDY % length)
        for point in load_study(path, folder).points.values():
            (folder / "grown" / "runs").mkdir(parents=True, exist_ok=True)
            run_point(point.parameters, folder / "grown" / "runs" / f"{point.id}.nc", quiet=True)
        output = build(path, folder)
    return xr.load_dataset(output)


def assert_equal(one: xr.Dataset, other: xr.Dataset) -> None:
    xr.testing.assert_equal(one.drop_vars(CLOCK), other.drop_vars(CLOCK))


def test_more_than_is_asked_for_is_left_out(tmp_path, short_dataset):
    grown = run_study(tmp_path, SHORT, LONG)
    assert grown.sizes["replicate"] == 2 and (grown["average"] == 4).all()
    study = load_study(tmp_path / "grown.yaml", tmp_path)
    assert survey(study, tmp_path).is_over
    assert_equal(run_study(tmp_path, SHORT), short_dataset)
    assert survey(load_study(tmp_path / "grown.yaml", tmp_path), tmp_path).is_over


def test_a_point_that_is_to_grow_waits(tmp_path):
    run_study(tmp_path, SHORT)
    (tmp_path / "grown.yaml").write_text(STUDY % LONG)
    status = survey(load_study(tmp_path / "grown.yaml", tmp_path), tmp_path)
    assert status.counts["waiting"] == 2 and not status.is_over


def test_a_point_that_is_to_grow_is_not_read(tmp_path):
    run_study(tmp_path, SHORT)
    (tmp_path / "grown.yaml").write_text(STUDY % LONG)
    with pytest.raises(InputError, match=r"\.nc: holds .*average 2 of .*average 4") as error:
        build(tmp_path / "grown.yaml", tmp_path)
    assert "(and 1 more)" in str(error.value)
    assert len(list((tmp_path / "grown" / "runs").glob("*.nc"))) == 2


def test_a_summary_is_that_of_what_is_wanted(tmp_path):
    run_study(tmp_path, SHORT, LONG)
    for length in (SHORT, LONG):
        (tmp_path / "grown.yaml").write_text(STUDY % length)
        for point in load_study(tmp_path / "grown.yaml", tmp_path).points.values():
            path = tmp_path / "grown" / "runs" / f"{point.id}.nc"
            scalars = summary_of(path, amounts(point.parameters)).scalars
            with netCDF4.Dataset(path) as file:
                group = file["shorter_1"] if length == SHORT else file
                expected = group["velocity"][: point.parameters.replicates]
            np.testing.assert_array_equal(scalars["velocity"], expected)
