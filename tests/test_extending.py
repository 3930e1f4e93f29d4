"""The examples of docs/extending.md: from made-up runs to dataset, figures, verdicts, report."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.claims import judge
from sim.claims.written import build as build_claims
from sim.dataset.build import build
from sim.dataset.earlier import reading_code
from sim.figures.several import draw_several
from sim.parameters.common import Parameters
from sim.report.page import build as build_report
from sim.report.publish import publish
from sim.study.load import Study, load_study
from tests.made.plugins import alone, forgotten
from tests.made.processes import ROOT
from tests.made.runs import write_run

EXAMPLES = ROOT / "docs" / "examples"
GUIDE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    with forgotten():
        yield


@pytest.fixture(autouse=True)
def _no_claims_of_papers(monkeypatch) -> None:
    monkeypatch.setattr(judge, "claims", lambda: ())


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Return a folder with the examples, in which everything happens."""
    for path in EXAMPLES.iterdir():
        if path.is_file():
            shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def make_runs(study: Study) -> None:
    for point in study.points.values():
        parameters: Parameters = point.parameters
        speed = 0.4 * np.array([0.99, 1.0, 1.01]) * (1.3 if parameters.angle == 18 else 1.0)
        packing = np.where(np.arange(8) < 3, 0.5, 0.0) * np.ones((3, 1))
        held = {"packing_profile": (("replicate", "height"), packing, {"units": "1"})}
        write_run(Path("results/own/runs"), parameters, speed, arrays=held)


@pytest.fixture
def made(folder) -> Path:
    """Return the results of the study of the examples, all but figures and report."""
    make_runs(load_study("own.yaml"))
    build("own.yaml")
    build_claims("own.yaml")
    return folder / "results" / "own"


def test_the_examples_go_the_whole_way(made, folder):
    with xr.open_dataset(made / "dataset.nc") as dataset:
        slip = dataset["base_slip"]
        assert slip.attrs["units"] == "1" and slip.attrs["long_name"].startswith("velocity of the")
        # The lowest slice is the only one below a diameter, and half as fast as the mean.
        assert np.allclose(slip, 0.5)
    draw_several(
        ["slip", "spread"],
        made / "dataset.nc",
        made / "figures",
        code="x",
        study_path=Path("own.yaml"),
    )
    assert "Boxes: quartiles" in (made / "figures" / "spread.caption.txt").read_text()
    table = (made / "figures" / "slip.csv").read_text()
    assert "velocity of the lowest diameter over the mean velocity [1]" in table
    (own,) = (
        c for c in json.loads((made / "claims.json").read_text())["claims"] if c["paper"] == "own"
    )
    assert own["id"] == "steeper_is_faster" and own["verdict"] == "reproduced"
    page = build_report("own.yaml").read_text()
    assert "What this study claims" in page and "Steeper flows are faster" in page
    assert "base_slip.py" in page and "Plug-ins" in page
    published = publish("own.yaml", target=folder / "published")
    assert (published / "steeper.py").is_file()


def test_an_edited_observable_is_computed_again_and_nothing_else_is_old(made, folder):
    before = reading_code()
    with forgotten():
        edited = (folder / "base_slip.py").read_text().replace("/ run[", "/ 2 / run[")
        (folder / "base_slip.py").write_text(edited)
        # As another process would find it.
        with alone():
            build("own.yaml")
            assert reading_code() != before
    with xr.open_dataset(made / "dataset.nc") as dataset:
        assert np.allclose(dataset["base_slip"], 0.25)


def test_a_mistake_in_a_plugin_is_one_line_and_harms_no_run_file(folder):
    wrong = (folder / "base_slip.py").read_text().replace('run["height"]', 'run["hight"]')
    (folder / "base_slip.py").write_text(wrong)
    make_runs(load_study("own.yaml"))
    with pytest.raises(InputError, match=r"observable base_slip of chute.*: line 15: KeyError"):
        build("own.yaml")
    assert not list(Path("results/own/runs").glob("*.damaged"))


def test_a_figure_is_old_when_its_plugin_is_edited(folder):
    spec = load_study("own.yaml").plots
    (folder / "boxes.py").write_text((folder / "boxes.py").read_text() + "# edited\n")
    with alone():
        other = load_study("own.yaml").plots
    assert repr(spec["slip"]) == repr(other["slip"])
    assert repr(spec["spread"]) != repr(other["spread"])
