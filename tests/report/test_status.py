"""How far a study is, told from made-up folders and from a run that is killed."""

import json
import os
import signal
import subprocess
import sys

import pytest

from sim.__main__ import main
from sim.base.errors import duration
from sim.engine.command import warm
from sim.engine.progress import read_progress
from sim.parameters import canonical_values, parse_point, point_id
from sim.report.status import STATES, as_json, as_text
from sim.study.points import estimate
from tests.made.folder import BOUNDED, EARLIER, LATER, STUDY, Folder
from tests.made.netcdf import edit_file
from tests.made.processes import refusal, start_run, wait_until
from tests.made.runs import FAILURE, write_run


@pytest.fixture
def folder(tmp_path) -> Folder:
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


def test_every_state_is_told_from_the_others(folder):
    done, failed, running, interrupted, _ = folder.ids
    folder.finish(done)
    folder.finish(failed, failed=[0])
    folder.write_progress(running)
    folder.write_progress(interrupted, updated=EARLIER)
    status = folder.survey()
    states = ["done", "failed", "running", "interrupted", "waiting"]
    assert [point.state for point in status.points.values()] == states
    assert status.points[failed].reason == FAILURE
    assert status.points[running].progress.percent == 50
    assert status.totals["cores"] == 1
    assert status.totals["core_seconds"] == pytest.approx(3.0)
    text = as_text(status)
    assert "5 points: 1 done, 1 failed, 1 running, 1 interrupted, 1 waiting" in text
    assert f"{failed}: {FAILURE}" in text


@pytest.mark.parametrize(
    ("changes", "state"),
    [
        ({}, "running"),
        ({"updated": LATER}, "running"),
        ({"updated": EARLIER}, "interrupted"),
        ({"host": "elsewhere"}, "running"),
        ({"host": "elsewhere", "updated": EARLIER}, "interrupted"),
        ({"point": "another"}, "waiting"),
    ],
    ids=[
        "its process lives",
        "the clock was put back",
        "its process number is another's now",
        "on another machine, of late",
        "on another machine, long ago",
        "of another point",
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


def test_a_killed_run_was_interrupted(tmp_path):
    text = "study: made\nseries: [{name: a, system: belt, base: {frequency: 20, average: 1.0e+5}}]"
    folder = Folder(tmp_path, text)
    (key,) = folder.ids
    point = folder.study.points[key].parameters
    warm([point])
    folder.runs.mkdir(parents=True)
    output = folder.runs / f"{key}.nc"
    process = start_run(point, output)
    try:
        wait_until(lambda: (said := read_progress(output)) and said.done > 1e5, process)
        running = folder.survey()
        assert running.counts["running"] == 1
        assert running.totals["seconds_left"] > 0 and running.points[key].progress.rate > 0
    finally:
        process.send_signal(signal.SIGKILL)
        process.communicate()
    assert folder.state(key) == "interrupted"
    assert "interrupted" in as_text(folder.survey())


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


def test_a_study_that_is_over_says_what_it_took(folder):
    for key in folder.ids:
        folder.finish(key)
    status = folder.survey()
    assert status.is_over and status.totals["seconds_left"] == 0.0
    assert as_text(status) == "made: A made-up study\n5 points: 5 done\n\n" + (
        "time of all runs 7.5 s, with compiling and waiting"
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


def test_json_holds_every_point(folder):
    folder.finish(folder.ids[0])
    folder.finish(folder.ids[1], failed=[0])
    folder.write_progress(folder.ids[2])
    document = json.loads(as_json(folder.survey()))
    assert document["counts"]["waiting"] == 2
    assert [point["id"] for point in document["points"]] == folder.ids
    _, failed, running, *_ = document["points"]
    assert failed["reason"] == FAILURE
    progress = {"done": 500, "total": 1000, "rate": 5e3, "elapsed": 10.0, "seconds_left": 10.0}
    assert running["progress"] == progress
    assert document["seconds_left"] > 0


def test_the_command_shows_a_study_until_it_is_over(folder, capsys):
    for key in folder.ids:
        folder.finish(key)
    options = ["--results", str(folder.results)]
    assert main(["status", str(folder.file), *options, "--watch", "5"]) == 0
    assert "5 points: 5 done" in capsys.readouterr().out
    assert main(["status", str(folder.file), *options, "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"]["done"] == 5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.yaml"], "none.yaml: no such file"),
        (["--watch", "0"], "--watch: got 0; allowed: a number in [1, 86400]"),
        (["--watch", "nan"], "--watch: got nan; allowed: a number in [1, 86400]"),
        (["--results", "README.md"], "--results: got 'README.md'; allowed: a folder"),
        (["--remove"], "--remove: got true; allowed: with --orphans"),
    ],
)
def test_mistakes_give_one_line(arguments, words, capsys):
    assert words in refusal(capsys, "status", *arguments)


@pytest.fixture
def shrunk(tmp_path) -> Folder:
    """A study of which every point is run, and then one value is taken out."""
    made = Folder(tmp_path)
    for key in made.ids:
        run = made.finish(key)
        run.with_name(f".{run.name}.state").write_bytes(bytes(1000))
    return Folder(tmp_path, STUDY.replace("[1, 2, 3]", "[1, 3]"))


def run_orphans(folder: Folder, *options: str) -> int:
    return main(
        ["status", "--orphans", str(folder.file), "--results", str(folder.results), *options]
    )


def test_orphans_are_told_left_alone_and_removed_when_told_to(shrunk, capsys):
    before = sorted(path.name for path in shrunk.runs.iterdir())
    status = shrunk.survey()
    (orphan,) = status.orphans
    assert orphan.startswith("chute-depth2-")
    assert "runs of no point of the study: 1" in as_text(status)
    assert f'"{orphan}"' in as_json(status)
    assert run_orphans(shrunk) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(orphan) and lines[-1].startswith("1 run, 0.")
    assert sorted(path.name for path in shrunk.runs.iterdir()) == before
    assert run_orphans(shrunk, "--remove") == 0
    left = {path.name for path in shrunk.runs.iterdir()}
    assert left == {name for key in shrunk.ids for name in (f"{key}.nc", f".{key}.nc.state")}
    assert not any(orphan in name for name in left)
    capsys.readouterr()
    assert run_orphans(shrunk, "--remove") == 0
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
