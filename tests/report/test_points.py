"""What `points` says of a study, of points that need no run here, and of a run file."""

import json
import re

import pytest
import xarray as xr
import yaml

from sim.__main__ import main
from sim.base.errors import InputError
from sim.base.seals import seal
from sim.parameters import BeltParameters, ChuteParameters, load_point, point_id
from sim.report.points import as_table, earlier_lines, show
from sim.report.runs import describe_run
from sim.study.load import parse_study
from tests.made.figures import make_built_study
from tests.made.folder import Folder
from tests.made.netcdf import edit_file
from tests.made.processes import refusal
from tests.made.runs import FAILURE, write_run


def test_points_that_another_study_has_are_named(tmp_path):
    folder = Folder(tmp_path)
    first, *others = folder.study.points.values()
    write_run(folder.results / "other" / "runs", first.parameters)
    table = show(folder.file, "table", results=folder.results)
    (line,) = (line for line in table.splitlines() if "in other studies" in line)
    assert line.startswith("1 point in other studies, not to be run: other (1); core time of the ")
    document = json.loads(show(folder.file, "json", results=folder.results))
    assert {point["id"]: point["shared"] for point in document["points"]} == {
        point.id: "" for point in others
    } | {first.id: str(folder.results / "other" / "runs" / f"{first.id}.nc")}
    assert not folder.runs.exists()


def test_one_time_is_told_of_what_is_left(tmp_path):
    folder = Folder(tmp_path)
    before = show(folder.file, "table", results=folder.results)
    assert "estimated core time" in before and "of the others" not in before
    write_run(folder.runs, next(iter(folder.study.points.values())).parameters)
    after = show(folder.file, "table", results=folder.results)
    assert "of which 1 have been run in" in after and "estimated core time" not in after
    assert after.count("core time of the others") == 1


def test_a_point_file_is_a_study_of_one_point(tmp_path, capsys):
    path = tmp_path / "point.yaml"
    path.write_text("system: chute\ndepth: 2.5\n")
    assert point_id(load_point(path)) in show(path, "table", results=tmp_path)
    path.write_text("system: chute\ndepht: 2.5\n")
    line = refusal(capsys, "points", path)
    assert line.startswith(f"error: {path}: depht: unknown key, got 2.5; did you mean depth?")


#: Parameters whose names fill an id.
MANY = {"law": "hertz", "attraction": "clipped", "tangential_unloading": "rescaled", "bumps": 1}
MANY |= {"diameter": 0.002, "mass": 1e-5, "gravity": 9.81, "friction_plane": 0.3}


def test_an_id_that_is_cut_is_shown_by_what_varies_and_named_so_as_a_start(tmp_path):
    series = [{"name": "a", "system": "chute", "base": MANY, "grid": {"angle": [20, 22.5]}}]
    study = parse_study({"study": "s", "series": series}, "s.yaml", None)
    whole = list(study.points)[1]
    assert "angle" not in whole
    shown = [line.split()[0] for line in as_table(study).splitlines() if line[:6] == "chute-"]
    assert shown[1] == f"chute-angle22.5-{whole[-8:]}"
    base = MANY | {"start_from": shown[1], "angle": 21}
    series.append({"name": "b", "system": "chute", "base": base})
    later = parse_study({"study": "s", "series": series}, "s.yaml", None)
    *before, last = later.points.values()
    assert last.parameters.start_from == whole and [one.id for one in before] == list(study.points)
    base["start_from"] = "chute-angle22.5-00000000"
    with pytest.raises(InputError, match=r"start_from: got 'chute-angle22\.5-0{8}'; allowed"):
        parse_study({"study": "s", "series": series}, "s.yaml", None)


def test_a_series_with_a_question_is_told_how_runs_of_its_length_ended(tmp_path):
    """A run counts if it is of the system and at most twice, at least half as long."""
    regimes = ["steady", "steady", "undetermined", "undetermined", "steady", "steady"]
    columns = {
        "system": ["belt"] * 5 + ["chute"],
        "transient": [10.0, 25.0, 30.0, 100.0, 130.0, 30.0],
        "average": [20.0] * 6,
        "point_regime": regimes,
    }
    for name in ("one", "damaged"):
        (tmp_path / name).mkdir()
    dataset = xr.Dataset({name: ("point", values) for name, values in columns.items()})
    dataset.to_netcdf(tmp_path / "one" / "dataset.nc", engine="netcdf4")
    (tmp_path / "damaged" / "dataset.nc").write_bytes(b"CDF")
    design = {"kind": "sobol", "points": 8, "over": {"frequency": [15, 50]}}
    series = {"name": "wide", "system": "belt", "base": {"transient": 40, "average": 22}}
    asked = {"study": "s", "series": [series | {"design": design}]}
    surrogate = {"surrogate": [{"name": "speed", "series": "wide"}]}
    study = parse_study(asked | surrogate, "s.yaml", None)
    assert earlier_lines(study, tmp_path) == [
        "series wide: of 3 points with runs of such a length in the results here, 1 steady, "
        "2 undetermined"
    ]
    assert earlier_lines(study, tmp_path / "none") == []
    assert earlier_lines(parse_study(asked, "s.yaml", None), tmp_path) == []


CHUTE = ChuteParameters(
    depth=2.5, friction=0.3, friction_plane=0.5, orientations=False, replicates=2
)
BELT = BeltParameters(frequency=62.5, integrator="verlet", seed=7)


@pytest.mark.parametrize("point", [CHUTE, BELT], ids=lambda point: point.system)
def test_the_point_of_a_run_reproduces_all_parameters(tmp_path, point):
    text = describe_run(write_run(tmp_path, point), as_point=True)
    (tmp_path / "again.yaml").write_text(text)
    assert load_point(tmp_path / "again.yaml") == point
    assert next(iter(yaml.safe_load(text))) == "system"


def test_a_run_is_told_in_full_and_nothing_of_it_moves_the_cursor(tmp_path, capsys):
    path = write_run(tmp_path, CHUTE, [0.5, 0.25], failed=[1])
    with edit_file(path) as file:
        file.command = "a\x1b[31mX\u202eb\x07"
    # As whoever has made it may have sealed it.
    seal(path)
    assert main(["points", str(path)]) == 0
    text = capsys.readouterr().out
    assert text.startswith(f"{path.stem}\nstatus: ") and "\n\nprovenance\n" in text
    assert re.search(r"friction_plane +0\.5\n", text)
    assert re.search(r" velocity \(m s-1\) +0\.5 \| nan\n", text)
    assert f"| {FAILURE}" in text and "source_hash" in text
    assert r"a\x1b[31mX\u202eb\x07" in text and "\x1b" not in text and "\u202e" not in text


def test_a_file_that_is_no_run_gives_one_line(tmp_path, capsys):
    path = tmp_path / "odd.nc"
    for content in (None, b"", b"no netCDF"):
        if content is not None:
            path.write_bytes(content)
        assert "odd.nc" in refusal(capsys, "points", path)
    dataset = make_built_study(tmp_path)[1] / "made" / "dataset.nc"
    line = refusal(capsys, "points", dataset)
    assert line == f"error: {dataset}: the dataset of study made, not a run file"
    assert dataset.exists()
