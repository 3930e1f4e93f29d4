"""Run files and datasets as other programs read them: the CF conventions."""

import contextlib
import io
import json
import subprocess
from pathlib import Path
from shutil import which

import netCDF4
import pytest
import xarray as xr

from sim.dataset.build import build
from sim.dataset.results import load_results
from sim.engine.run import run_point
from sim.parameters import SYSTEMS, parse_point
from tests.made.figures import make_built_study
from tests.made.runs import write_run

POINTS = {
    "belt": {"system": "belt", "beads": 10, "width": 5, "frequency": 30, "replicates": 2},
    "chute": {"system": "chute", "depth": 1.5, "cell": 4},
}

#: Messages of the checker that docs/data.md explains.
EXPLAINED = ("Coordinate variable 'time' should have standard_name='time', found: 'None'",)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    return make_built_study(tmp_path_factory.mktemp("made"))[1] / "made" / "dataset.nc"


@pytest.fixture(scope="module", params=POINTS)
def run(request, tmp_path_factory) -> Path:
    """Run a short point and return its file."""
    path = tmp_path_factory.mktemp("runs") / "run.nc"
    point = POINTS[request.param] | {"transient": 1, "average": 2, "trajectory": 1}
    run_point(parse_point(point, "point"), path, quiet=True)
    return path


def test_variables_of_a_run_say_what_they_are(run):
    with netCDF4.Dataset(run) as file:
        assert file.Conventions == "CF-1.11" and file.command in file.history
        lacking = [name for name, one in file.variables.items() if "long_name" not in one.ncattrs()]
        assert lacking == []
        assert "axis" not in file["time"].ncattrs() and file["time"].units == "s"
        assert file["height"].standard_name == "height"
        # CF has only numbers as coordinates.
        assert all(file[name].ndim == 2 for name in ("frame", "axis"))
    with xr.open_dataset(run) as opened:
        assert list(opened.frame) == ["first", "last"] and opened.axis.dims == ("axis",)


@pytest.mark.skipif(not (which("cdo") and which("ncpdq")), reason="CDO and NCO are not installed")
def test_cdo_reads_time_series_once_time_comes_first(run, tmp_path):
    """As docs/data.md says."""
    turned = tmp_path / "cdo.nc"
    subprocess.run(["ncpdq", "-a", "time,replicate", run, turned], check=True)
    words = ["cdo", "-s", "outputf,%.9g,1", "-timmean", "-selname,mean_velocity", turned]
    said = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    with xr.open_dataset(run) as opened:
        mean = opened.mean_velocity.mean("time").values
    assert [float(one) for one in said.split()] == pytest.approx(mean, rel=1e-6)


def test_a_run_tells_parameters_in_si_and_its_unit_of_velocity(run):
    with xr.open_dataset(run) as opened:
        scaled = {name: one.attrs for name, one in opened.items() if "si_value" in one.attrs}
        point = {name: opened[name].item() for name in opened if opened[name].ndim == 0}
    assert {"transient", "average"} < set(scaled)
    for name, attrs in scaled.items():
        assert attrs["comment"].startswith("multiple of") and attrs["si_units"]
        if name == "cell":
            assert attrs["si_value"] == pytest.approx(point["cell"] * point["diameter"])
    unit = (point["gravity"] * point["diameter"]) ** 0.5
    with netCDF4.Dataset(run) as file:
        assert file.velocity_unit == pytest.approx(unit)


def test_variables_of_a_dataset_say_what_they_are(dataset):
    with netCDF4.Dataset(dataset) as file:
        assert file.last_run in file.history
        named = [file, *(file[name] for name in ("natural", "si", "chute", "belt"))]
        for group in named:
            for name, one in group.variables.items():
                assert "long_name" in one.ncattrs(), name
        assert file["point"].ndim == 2


def test_velocities_are_there_in_natural_units_and_parameters_in_si(dataset):
    root, natural, si = (xr.load_dataset(dataset, group=name) for name in (None, "natural", "si"))
    unit = (root.gravity * root.diameter) ** 0.5
    xr.testing.assert_allclose(natural.point_velocity * unit, root.point_velocity)
    assert natural.velocity.dims == root.velocity.dims and natural.velocity.units == "1"
    belts = root.system.values == "belt"
    expected = (root.amplitude * root.diameter).values[belts]
    assert si.amplitude.values[belts] == pytest.approx(expected)
    assert si.amplitude[~belts].isnull().all() and si.stiffness.units == "N m-1"


def test_a_study_of_one_system_has_no_columns_of_the_other(tmp_path):
    study = tmp_path / "belts.yaml"
    study.write_text("study: belts\nseries: [{name: one, system: belt}]\n")
    write_run(tmp_path / "results" / "belts" / "runs", parse_point({"system": "belt"}, "point"))
    path = build(study, tmp_path / "results")
    with xr.open_dataset(path) as held:
        assert set(SYSTEMS["belt"].model_fields) <= set(held.coords)
        assert not {"depth", "law"} & set(held.variables)
    everything = load_results(path).dataset
    assert everything.depth.isnull().all() and everything.law.isnull().all()


def test_the_points_of_one_system_come_without_what_the_other_has(dataset):
    results = load_results(dataset)
    belts = results.of("belt")
    assert set(belts.system.values) == {"belt"} and "depth" not in belts.variables
    assert "base_normal" in results.of("chute") and "base_normal" not in belts
    assert len(belts.point) + len(results.of("chute").point) == len(results.dataset.point)


def complaints(path: Path, report: Path) -> list[str]:
    """Return the messages of the compliance checker for a file, each once."""
    checker = pytest.importorskip("compliance_checker.runner")
    checker.CheckSuite.load_all_available_checkers()
    with contextlib.redirect_stdout(io.StringIO()):
        checker.ComplianceChecker.run_checker(
            str(path), ["cf:1.11"], 1, "strict", output_filename=str(report), output_format="json"
        )
    told = json.loads(report.read_text(encoding="utf-8"))["cf:1.11"]
    levels = ("high_priorities", "medium_priorities", "low_priorities")
    return sorted({text for level in levels for one in told[level] for text in one["msgs"]})


@pytest.mark.long
def test_the_checker_says_of_a_run_only_what_is_explained(run, tmp_path):
    assert set(complaints(run, tmp_path / "report.json")) <= set(EXPLAINED)


@pytest.mark.long
def test_the_checker_says_nothing_of_a_dataset(dataset, tmp_path):
    assert complaints(dataset, tmp_path / "report.json") == []
