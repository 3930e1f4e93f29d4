"""What `points` says of points that need no run here."""

import json

import pytest

from sim.report.points import show
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
