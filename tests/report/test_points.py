"""What `points` says of points that need no run here."""

import json

import pytest
import xarray as xr

from sim.report import earlier_regimes
from sim.report.points import show
from sim.study.load import parse_study
from tests.made.folder import Folder
from tests.made.runs import write_run


@pytest.fixture
def folder(tmp_path) -> Folder:
    folder = Folder(tmp_path)
    first = next(iter(folder.study.points.values()))
    write_run(folder.results / "other" / "runs", first.parameters)
    return folder


def test_one_line_says_how_many_points_another_study_has(folder):
    table = show(folder.file, folder.results, "table")
    (line,) = (line for line in table.splitlines() if "in other studies" in line)
    assert line.startswith("1 point in other studies, not to be run: other (1); core time of the ")


def test_json_names_their_run_files(folder):
    document = json.loads(show(folder.file, folder.results, "json"))
    first, *others = folder.ids
    shared = {point["id"]: point["shared"] for point in document["points"]}
    assert shared == dict.fromkeys(others, "") | {
        first: str(folder.results / "other" / "runs" / f"{first}.nc")
    }
    assert not folder.runs.exists()


def write_earlier(folder, **columns):
    folder.mkdir(parents=True)
    xr.Dataset({name: ("point", values) for name, values in columns.items()}).to_netcdf(
        folder / "dataset.nc", engine="netcdf4"
    )


def test_a_series_with_a_question_is_told_how_runs_of_its_length_ended(tmp_path):
    """A run counts if it is of the system and at most twice, at least half as long."""
    lengths = [10.0, 25.0, 30.0, 100.0, 130.0]
    write_earlier(
        tmp_path / "one",
        system=["belt"] * 5,
        transient=lengths,
        average=[20.0] * 5,
        point_regime=["steady", "steady", "undetermined", "undetermined", "steady"],
    )
    write_earlier(
        tmp_path / "other",
        system=["chute"],
        transient=[30.0],
        average=[20.0],
        point_regime=["steady"],
    )
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "dataset.nc").write_bytes(b"CDF")
    design = {"kind": "sobol", "points": 8, "over": {"frequency": [15, 50]}}
    series = {"name": "wide", "system": "belt", "base": {"transient": 40, "average": 22}}
    asked = {"study": "s", "series": [series | {"design": design}]}
    surrogate = {"surrogate": [{"name": "speed", "series": "wide"}]}
    study = parse_study(asked | surrogate, "s.yaml", None)
    assert earlier_regimes.lines(study, tmp_path) == [
        "series wide: of 3 points with runs of such a length in the results here, 1 steady, "
        "2 undetermined"
    ]
    assert earlier_regimes.lines(study, tmp_path / "none") == []
    assert earlier_regimes.lines(parse_study(asked, "s.yaml", None), tmp_path) == []
