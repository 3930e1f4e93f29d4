"""How far a study is, told from made-up folders and from a run that is killed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from sim.__main__ import main
from sim.base.errors import duration
from sim.parameters import canonical_values, parse_point, point_id
from sim.report.status import STATES, as_json, as_text
from sim.study.command import go_to_results
from sim.study.load import load_study
from sim.study.model import estimate
from tests.made.folder import BOUNDED, EARLIER, LATER, STUDY, Folder
from tests.made.netcdf import edit_file
from tests.made.processes import refusal
from tests.made.runs import FAILURE, write_run


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Folder:
    monkeypatch.chdir(tmp_path)
    return Folder(tmp_path)


def test_a_study_that_was_not_started_waits(folder):
    status = folder.survey()
    assert status.counts == dict.fromkeys(STATES, 0) | {"waiting": 5}
    cost = sum(estimate(point.parameters).core_seconds for point in folder.study.points.values())
    assert status.core_seconds_left == pytest.approx(cost)
    assert status.totals["seconds_left"] is None and not status.is_over
    assert "5 points: 5 waiting" in as_text(status)
    assert "nothing is running" in as_text(status)
    assert not folder.results.exists()


def test_results_beside_the_study_file_are_found_from_elsewhere(folder, monkeypatch, capsys):
    folder.finish(folder.ids[0])
    elsewhere = folder.file.parent / "other" / "place"
    elsewhere.mkdir(parents=True)
    monkeypatch.chdir(elsewhere)
    file = Path("../../made.yaml")
    for command in ("status", "points"):
        assert main([command, str(file)]) == 0
    assert "5 points: 1 done, 4 waiting" in (output := capsys.readouterr().out)
    assert "of which 1 have been run in ../../results/made" in output
    study = load_study(file)
    assert go_to_results(study) == Path("made.yaml") and Path.cwd() == folder.file.parent
    # Results in the present folder come first.
    (elsewhere / "results" / "made").mkdir(parents=True)
    monkeypatch.chdir(elsewhere)
    assert go_to_results(study) == file and Path.cwd() == elsewhere


def test_every_state_is_told_in_text_and_in_json(folder, capsys):
    done, failed, running, interrupted, _ = folder.ids
    folder.finish(done)
    folder.finish(failed, failed=[0])
    folder.write_progress(running)
    folder.write_progress(interrupted, updated=EARLIER)
    status = folder.survey()
    states = ["done", "failed", "running", "interrupted", "waiting"]
    assert [point.state for point in status.points.values()] == states
    assert status.points[running].progress.percent == 50
    assert status.totals["cores"] == 1
    assert status.totals["core_seconds"] == pytest.approx(3.0)
    text = as_text(status)
    assert "5 points: 1 done, 1 failed, 1 running, 1 interrupted, 1 waiting" in text
    assert f"{failed}: {FAILURE}" in text
    assert main(["status", str(folder.file), "--format", "json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["counts"] == dict.fromkeys(STATES, 1) and document["seconds_left"] > 0
    assert [point["id"] for point in document["points"]] == folder.ids
    assert document["points"][1]["reason"] == FAILURE
    progress = {"done": 500, "total": 1000, "rate": 5e3, "elapsed": 10.0, "seconds_left": 10.0}
    assert document["points"][2]["progress"] == progress


@pytest.mark.parametrize(
    ("changes", "state"),
    [
        # The clock was put back; the process number is another's now.
        ({"updated": LATER}, "running"),
        ({"updated": EARLIER}, "interrupted"),
        ({"host": "elsewhere"}, "running"),
        ({"host": "elsewhere", "updated": EARLIER}, "interrupted"),
        ({"point": "another"}, "waiting"),
    ],
)
def test_a_run_goes_on_or_was_interrupted(folder, changes, state):
    folder.write_progress(folder.ids[0], **changes)
    assert folder.state(folder.ids[0]) == state


def test_a_process_that_has_gone_was_interrupted(folder):
    gone = subprocess.Popen([sys.executable, "-c", ""])
    folder.write_progress(folder.ids[0], pid=gone.pid, updated=LATER)
    # First a process that has ended and that its parent has not asked for, then none at all.
    os.waitid(os.P_PID, gone.pid, os.WEXITED | os.WNOWAIT)
    assert folder.state(folder.ids[0]) == "interrupted"
    gone.wait()
    assert folder.state(folder.ids[0]) == "interrupted"


@pytest.mark.parametrize("content", [b"", b'{"point": "x"', b"[3]"])
def test_a_progress_file_that_says_nothing_is_none(folder, content):
    folder.write_progress(folder.ids[0]).write_bytes(content)
    assert folder.state(folder.ids[0]) == "waiting"


def test_what_another_study_has_is_told_and_takes_no_time(folder):
    first, *others = folder.ids
    before = folder.survey().core_seconds_left
    write_run(folder.results / "other" / "runs", folder.study.points[first].parameters)
    status = folder.survey()
    assert status.points[first].state == "waiting" and not status.is_over
    assert status.core_seconds_left < before
    assert "1 point in other studies, not to be run: other (1)" in as_text(status)
    entries = {entry["id"]: entry for entry in json.loads(as_json(status))["points"]}
    assert entries[first]["shared"] == str(folder.results / "other" / "runs" / f"{first}.nc")
    assert all("shared" not in entries[key] for key in others)


@pytest.mark.parametrize("content", [b"", b"text", None])
def test_a_run_file_that_is_none_has_failed(folder, content):
    first, second, *_ = folder.ids
    other = folder.finish(second).read_bytes()
    path = folder.runs / f"{first}.nc"
    path.write_bytes(other if content is None else content)
    point = folder.survey().points[first]
    assert (point.state, point.core_seconds) == ("failed", 0.0)
    assert point.reason == f"{path}: not the run file of this point; delete it and rerun"


def test_a_run_that_replaces_its_file_is_running(folder):
    key = folder.ids[0]
    folder.finish(key)
    assert folder.state(key) == "done"
    folder.write_progress(key)
    assert folder.state(key) == "running"
    folder.write_progress(key, updated=EARLIER)
    assert folder.state(key) == "done"


def test_time_left_is_on_the_cores_in_use_and_of_what_runs_have_left(folder):
    for key in folder.ids[:2]:
        folder.write_progress(key)
    for key in folder.ids[2:]:
        folder.finish(key)
    status = folder.survey()
    half = [estimate(folder.study.points[key].parameters).core_seconds / 2 for key in folder.ids]
    left = sum(half[:2]) * 4.5 / sum(half[2:]) / 2
    assert (status.totals["cores"], status.core_seconds_left) == (2, pytest.approx(left))
    assert status.totals["seconds_left"] == pytest.approx(left / 2)
    assert f"time left about {duration(left / 2)} on 2 cores" in as_text(status)


def test_points_of_later_rounds_belong_to_the_study(tmp_path):
    folder = Folder(tmp_path, BOUNDED)
    extra = parse_point({"system": "chute", "depth": 2.5}, "test")
    rounds = folder.results / "made" / "rounds"
    rounds.mkdir(parents=True)
    (rounds / "1.json").write_text(json.dumps({point_id(extra): canonical_values(extra)}))
    (rounds / "9.json").write_text("of another study")
    assert list(folder.survey().points) == [*folder.ids, point_id(extra)]


def test_text_is_a_short_aligned_table_of_what_has_started_and_failed(tmp_path):
    folder = Folder(tmp_path, STUDY.replace("[1, 2, 3]", str([1 + n / 10 for n in range(30)])))
    for number, key in enumerate(folder.ids[:30]):
        folder.write_progress(key) if number % 2 else folder.finish(key, failed=[0])
    lines = as_text(folder.survey()).splitlines()
    table = [line for line in lines if line.startswith("running ")]
    assert len(table) == 8 and {line.index("chute-") for line in table} == {
        len("running    50 %     0.0     10.0 s  about 10.0 s  ")
    }
    assert "and 7 more" in lines and "and 10 more" in lines and len(lines) <= 24


def test_a_study_is_shown_until_it_is_over_and_says_what_it_took(folder, capsys):
    for key in folder.ids:
        folder.finish(key)
    assert folder.survey().is_over and folder.survey().totals["seconds_left"] == 0.0
    assert main(["status", str(folder.file), "--watch", "5"]) == 0
    assert capsys.readouterr().out == "made: A made-up study\n5 points: 5 done\n\n" + (
        "time of all runs 7.5 s, with compiling and waiting\n"
    )


def test_points_with_a_caveat_are_counted(folder):
    leaking = {"energy_residual": ("replicate", [-0.012], {"units": "1"})}
    folder.finish(folder.ids[0], arrays=leaking)
    path = folder.finish(folder.ids[3])
    with edit_file(path) as run:
        run.caveat = "the time step is long"
    folder.finish(folder.ids[4])
    status = folder.survey()
    assert "5 points: 3 done, 2 waiting; 2 with a caveat" in as_text(status)
    document = json.loads(as_json(status))
    assert document["caveats"] == 2
    told = [point.get("caveat", "") for point in document["points"]]
    assert "energy does not add up" in told[0]
    assert told[1:] == ["", "", "the time step is long", ""]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.yaml"], "none.yaml: no such file"),
        (["--watch", "0"], "--watch: got 0; allowed: a number in [1, 86400]"),
        (["--watch", "nan"], "'--watch': 'nan' is not a decimal number"),
        (["--remove"], "--remove: got true; allowed: with --orphans"),
    ],
)
def test_mistakes_give_one_line(arguments, words, capsys):
    assert words in refusal(capsys, "status", *arguments)


def run_orphans(folder: Folder, *options: str) -> int:
    return main(["status", "--orphans", str(folder.file), *options])


def test_orphans_are_told_left_alone_and_removed_when_told_to(tmp_path, monkeypatch, capsys):
    """Of a study of which one value is taken out: a whole run, and what a stopped one has left."""
    monkeypatch.chdir(tmp_path)
    made = Folder(tmp_path)
    _, whole, stopped, *_ = made.ids
    for key in made.ids:
        made.write_progress(key) if key == stopped else made.finish(key)
        (made.runs / f".{key}.nc.state").write_bytes(bytes(1000))
    shrunk = Folder(tmp_path, STUDY.replace("[1, 2, 3]", "[1]"))
    before = sorted(path.name for path in shrunk.runs.iterdir())
    status = shrunk.survey()
    assert status.orphans == (whole, stopped)
    assert "runs of no point of the study: 2" in as_text(status)
    assert f'"{whole}"' in as_json(status)
    assert run_orphans(shrunk) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(whole) and lines[-1].startswith("2 runs, 0.")
    assert sorted(path.name for path in shrunk.runs.iterdir()) == before
    assert run_orphans(shrunk, "--remove") == 0
    left = {path.name for path in shrunk.runs.iterdir()}
    assert left == {name for key in shrunk.ids for name in (f"{key}.nc", f".{key}.nc.state")}
    capsys.readouterr()
    assert run_orphans(shrunk, "--remove") == 0
    assert capsys.readouterr().out == "none\n"


def test_nothing_is_an_orphan_while_rounds_are_to_come(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = Folder(tmp_path)
    made.finish(made.ids[0])
    bounded = Folder(tmp_path, BOUNDED)
    assert bounded.survey().orphans == ()
    assert "boundaries: got '" in refusal(
        capsys, "status", "--orphans", str(bounded.file), "--remove"
    )
    assert (made.runs / f"{made.ids[0]}.nc").exists()
