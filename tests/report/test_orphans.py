"""Runs of points that are no longer in a study: listed, and removed only when told to."""

import pytest

from sim.__main__ import main
from sim.report.status_table import as_json, as_text
from tests.made.folder import BOUNDED, STUDY, Folder


@pytest.fixture
def folder(tmp_path) -> Folder:
    """A study of which every point is run, and then one value is taken out."""
    made = Folder(tmp_path)
    for key in made.ids:
        run = made.finish(key)
        run.with_name(f".{run.name}.state").write_bytes(bytes(1000))
    return Folder(tmp_path, STUDY.replace("[1, 2, 3]", "[1, 3]"))


def run_orphans(folder: Folder, *options: str) -> int:
    return main(["orphans", str(folder.file), "--results", str(folder.results), *options])


def test_orphans_are_told_and_left_alone(folder, capsys):
    before = sorted(path.name for path in folder.runs.iterdir())
    status = folder.survey()
    (orphan,) = status.orphans
    assert orphan.startswith("chute-depth2-")
    assert "runs of no point of the study: 1" in as_text(status)
    assert f'"{orphan}"' in as_json(status)
    assert run_orphans(folder) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(orphan) and lines[-1].startswith("1 run, 0.")
    assert sorted(path.name for path in folder.runs.iterdir()) == before


def test_orphans_are_removed_when_told_to(folder, capsys):
    (orphan,) = folder.survey().orphans
    assert run_orphans(folder, "--remove") == 0
    left = {path.name for path in folder.runs.iterdir()}
    assert left == {name for key in folder.ids for name in (f"{key}.nc", f".{key}.nc.state")}
    assert not any(orphan in name for name in left)
    capsys.readouterr()
    assert run_orphans(folder, "--remove") == 0
    assert capsys.readouterr().out == "none\n"


def test_what_a_run_that_was_stopped_has_left_is_removed_too(tmp_path, capsys):
    made = Folder(tmp_path)
    kept, gone = made.ids[0], made.ids[1]
    for key in (kept, gone):
        made.write_progress(key)
        (made.runs / f".{key}.nc.state").write_bytes(bytes(1000))
    folder = Folder(tmp_path, STUDY.replace("[1, 2, 3]", "[1, 3]"))
    assert run_orphans(folder) == 0
    assert capsys.readouterr().out.startswith(f"{gone}  0.0 MB\n1 run, ")
    assert run_orphans(folder, "--remove") == 0
    left = {f".{kept}.nc.state", f".{kept}.nc.progress"}
    assert {path.name for path in folder.runs.iterdir()} == left


def test_nothing_is_an_orphan_while_rounds_are_to_come(tmp_path, capsys):
    made = Folder(tmp_path)
    made.finish(made.ids[0])
    bounded = Folder(tmp_path, BOUNDED)
    assert bounded.survey().orphans == ()
    assert run_orphans(bounded, "--remove") == 2
    assert "boundaries: got '" in capsys.readouterr().err
    assert (made.runs / f"{made.ids[0]}.nc").exists()
