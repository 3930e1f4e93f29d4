"""The benchmark of large studies measures what it says it does."""

import subprocess

import pytest
import xarray as xr

from benchmarks import scale
from sim.dataset.build import build
from sim.parameters import parse_point
from sim.report.status import survey
from sim.study.load import load_study
from tests.made.runs import write_run


def test_copies_of_a_run_make_a_study(tmp_path, monkeypatch):
    monkeypatch.setattr(scale, "ROW", 3)
    template = write_run(tmp_path, parse_point({"system": "belt", "replicates": 2}, "test"), 0.25)
    path = scale.write_study(tmp_path, 2, 2, added=1)
    scale.fill(tmp_path, path, template, 1)
    results = tmp_path / "results"
    study = load_study(path, results)
    assert survey(study, results).counts["done"] == len(study.points) == 7
    with xr.open_dataset(build(path, results)) as dataset:
        assert (dataset["velocity"] == 0.25).all()
        assert set(dataset["frequency"].values) == {20, 21}


def test_a_command_costs_time_and_memory(tmp_path):
    assert min(scale.cost(tmp_path, "sim", "--version")) >= 0
    with pytest.raises(subprocess.CalledProcessError):
        scale.cost(tmp_path, "sim", "dataset", "none.yaml")
