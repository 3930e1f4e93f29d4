"""How far a study is, told from made-up folders and from a run that is killed."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from sim.cli import main
from sim.cost import PROCESS_TIME, estimate
from sim.parameters import canonical, parse_point, point_id
from sim.progress import Progress, progress_file, read_progress
from sim.provenance import source_hash
from sim.status import PointStatus, StudyStatus, survey
from sim.status_table import as_json, as_text
from sim.study import load_study
from sim.warm import warm
from tests.factories import FAILURE, write_run

ROOT = Path(__file__).parents[1]

STUDY = """\
study: made
title: A made-up study
series:
  - {name: flows, system: chute, grid: {depth: [1, 2, 3]}}
  - {name: beds, system: belt, grid: {frequency: [20, 30]}}
"""
NOW = datetime.now(UTC)
EARLIER = NOW - timedelta(days=400)
LATER = NOW + timedelta(days=400)


class Folder:
    """A study without results, and ways to give it some."""

    def __init__(self, root: Path, text: str = STUDY):
        self.file = root / "made.yaml"
        self.file.write_text(text)
        self.results = root / "results"
        self.runs = self.results / "made" / "runs"
        self.study = load_study(self.file, self.results)
        self.ids = list(self.study.points)

    def finish(self, key: str, **how) -> Path:
        how = {"source_hash": source_hash()} | how
        return write_run(self.runs, self.study.points[key].parameters, **how)

    def say(self, key: str, **changes) -> Path:
        """Write the progress file of a run of this process that is halfway."""
        said = {
            "point": key,
            "done": 500,
            "total": 1000,
            "at_most": False,
            "particles": 100,
            "rate": 5e3,
            "elapsed": 10.0,
            "started": NOW,
            "updated": datetime.now(UTC),
            "expires": datetime.now(UTC) + timedelta(seconds=100),
            "pid": os.getpid(),
            "host": socket.gethostname(),
        }
        self.runs.mkdir(parents=True, exist_ok=True)
        path = progress_file(self.runs / f"{key}.nc")
        path.write_text(Progress(**said | changes).model_dump_json())
        return path

    def survey(self) -> StudyStatus:
        return survey(self.study, self.results)

    def state(self, key: str) -> str:
        return self.survey().points[key].state


@pytest.fixture
def folder(tmp_path) -> Folder:
    return Folder(tmp_path)


def test_a_study_that_was_not_started_waits(folder):
    status = folder.survey()
    assert status.counts == {"done": 0, "failed": 0, "running": 0, "interrupted": 0, "waiting": 5}
    cost = sum(estimate(point.parameters).core_seconds for point in folder.study.points.values())
    assert status.core_seconds_left == pytest.approx(cost)
    assert status.left is None and not status.is_over
    assert "5 points: 5 waiting" in as_text(status)
    assert "nothing is running" in as_text(status)
    assert not folder.results.exists()


def test_every_state_is_told_from_the_others(folder):
    done, failed, running, interrupted, _ = folder.ids
    folder.finish(done)
    folder.finish(failed, failed=[0])
    folder.say(running)
    folder.say(interrupted, updated=EARLIER)
    status = folder.survey()
    states = ["done", "failed", "running", "interrupted", "waiting"]
    assert [point.state for point in status.points.values()] == states
    assert status.points[failed].reason == FAILURE
    assert status.points[running].progress.percent == 50
    assert status.cores == 1
    assert status.core_seconds == pytest.approx(3.0)
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
        ({"host": "elsewhere", "updated": EARLIER}, "running"),
        ({"host": "elsewhere", "expires": EARLIER}, "interrupted"),
        ({"host": "elsewhere", "updated": LATER, "expires": LATER}, "interrupted"),
        ({"point": "another"}, "waiting"),
    ],
    ids=[
        "its process lives",
        "the clock was put back",
        "its process number is another's now",
        "on another machine, of late",
        "on another machine, with slow samples",
        "on another machine, long ago",
        "on another machine, in the future",
        "of another point",
    ],
)
def test_a_run_goes_on_or_was_interrupted(folder, changes, state):
    folder.say(folder.ids[0], **changes)
    assert folder.state(folder.ids[0]) == state


def test_a_process_that_has_gone_was_interrupted(folder):
    gone = subprocess.Popen([sys.executable, "-c", ""])
    folder.say(folder.ids[0], pid=gone.pid, updated=LATER)
    # First a process that has ended and that its parent has not asked for, then none at all.
    os.waitid(os.P_PID, gone.pid, os.WEXITED | os.WNOWAIT)
    assert folder.state(folder.ids[0]) == "interrupted"
    gone.wait()
    assert folder.state(folder.ids[0]) == "interrupted"


@pytest.mark.parametrize("content", [b"", b"\x89HDF", b'{"point": "x"', b"{}", b"[3]"])
def test_a_progress_file_that_says_nothing_is_none(folder, content):
    folder.say(folder.ids[0]).write_bytes(content)
    assert folder.state(folder.ids[0]) == "waiting"


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
    folder.say(key)
    assert folder.state(key) == "running"
    folder.say(key, updated=EARLIER)
    assert folder.state(key) == "done"


def test_a_file_that_changes_is_read_again(folder):
    key = folder.ids[0]
    os.utime(folder.finish(key), ns=(1, 1))
    assert folder.state(key) == "done"
    os.utime(folder.finish(key, failed=[0]), ns=(2, 2))
    assert folder.state(key) == "failed"


def test_runs_of_another_engine_are_counted(folder):
    folder.finish(folder.ids[0], source_hash="another")
    folder.finish(folder.ids[1])
    status = folder.survey()
    assert [point.outdated for point in status.points.values()] == [True, *[False] * 4]
    assert "to be run again: 1 points" in as_text(status)


def test_time_left_follows_what_done_points_took(folder):
    """The runs of `write_run` took 1.5 s, whatever was estimated."""
    parameters = [folder.study.points[key].parameters for key in folder.ids]
    computing = [estimate(one).core_seconds - PROCESS_TIME for one in parameters]
    folder.finish(folder.ids[0])
    chutes = sum(PROCESS_TIME + 1.5 * one / computing[0] for one in computing[1:3])
    belts = sum(PROCESS_TIME + one for one in computing[3:])
    assert folder.survey().core_seconds_left == pytest.approx(chutes + belts)


def test_a_run_that_ended_early_says_nothing_of_full_lengths(tmp_path):
    text = STUDY + "  - {name: known, system: chute, base: {protocol: converged}}\n"
    folder = Folder(tmp_path, text)
    before = folder.survey().core_seconds_left
    converged = folder.ids[-1]
    folder.finish(converged)
    cost = estimate(folder.study.points[converged].parameters).core_seconds
    assert folder.survey().core_seconds_left == pytest.approx(before - cost)


def test_time_left_is_on_the_cores_in_use(folder):
    for key in folder.ids[:2]:
        folder.say(key)
    for key in folder.ids[2:]:
        folder.finish(key)
    status = folder.survey()
    # 500 steps of 100 particles at 5,000 particle-steps per second.
    assert (status.cores, status.core_seconds_left, status.left) == (2, 20.0, 10.0)
    assert "time left about 10.0 s on 2 cores" in as_text(status)
    folder.say(folder.ids[0], done=0)
    assert folder.survey().left == 20.0


def test_time_left_of_runs_that_may_end_early_is_a_bound(tmp_path):
    text = STUDY.replace("title:", "defaults: {chute: {protocol: converged}}\ntitle:")
    folder = Folder(tmp_path, text)
    assert "left at most" in as_text(folder.survey())
    folder.finish(folder.ids[0])
    assert "left about" in as_text(folder.survey())
    folder.say(folder.ids[1], at_most=True)
    text = as_text(folder.survey())
    assert "time left at most" in text and "at most 10.0 s" in text


#: A study with rounds of refinement.
BOUNDED = (
    "study: made\nboundaries: [{name: b, system: chute, of: flow, along: friction, "
    "range: [0.3, 0.8], tolerance: 0.05}]"
)


def test_points_of_later_rounds_belong_to_the_study(tmp_path):
    folder = Folder(tmp_path, BOUNDED)
    extra = parse_point({"system": "chute", "depth": 2.5}, "test")
    rounds = folder.results / "made" / "rounds"
    rounds.mkdir(parents=True)
    (rounds / "1.json").write_text(json.dumps({point_id(extra): canonical(extra)}))
    (rounds / "9.json").write_text("of another study")
    assert list(folder.survey().points) == [*folder.ids, point_id(extra)]


def screenful(points: int) -> StudyStatus:
    said = {"at_most": True, "particles": 1000, "rate": 45e6, "elapsed": 4000.0, "pid": 1}
    said |= {"done": 1, "total": 10**12, "started": NOW, "updated": NOW, "expires": NOW}
    name = "chute-depth5-friction0.4-restitution0.85-stiffness100-tangential_exponent0.5-{:08x}"
    made = {}
    for index in range(points):
        key = name.format(index)
        progress = Progress(point=key, host="here", **said)
        made[f"{key[:-8]}a{key[-7:]}"] = PointStatus("running", 1, progress=progress)
        made[f"{key[:-8]}b{key[-7:]}"] = PointStatus("failed", 1, reason=f"{FAILURE} " * 5)
    return StudyStatus("made", "A made-up study", made, 1e6, 1e4, True)


def test_text_is_one_aligned_screenful():
    status = screenful(100)
    lines = as_text(status, 80).splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80
    table = [line for line in lines if " running " in line and "points" not in line]
    assert len(table) == 8
    assert len({len(line) for line in table}) == 1
    assert "and 92 more" in lines and "and 95 more" in lines
    assert table[0].split("  ")[0].endswith("-a0000000")
    assert "45.0" in table[0]
    assert next(iter(status.points)) in as_text(status)


def test_a_study_that_is_over_says_what_it_took(folder):
    for key in folder.ids:
        folder.finish(key)
    status = folder.survey()
    assert status.is_over and status.left == 0.0
    assert as_text(status) == "made: A made-up study\n5 points: 5 done\n\ncore time 7.5 s"


def test_json_holds_every_point(folder):
    folder.finish(folder.ids[0])
    folder.finish(folder.ids[1], failed=[0])
    folder.say(folder.ids[2])
    document = json.loads(as_json(folder.survey()))
    assert document["counts"]["waiting"] == 2
    assert [point["id"] for point in document["points"]] == folder.ids
    _, failed, running, *_ = document["points"]
    assert failed["reason"] == FAILURE
    assert (running["done"], running["total"], running["seconds_left"]) == (500, 1000, 10.0)
    assert document["seconds_left"] > 0


def test_the_command_shows_a_study_until_it_is_over(folder, capsys):
    for key in folder.ids:
        folder.finish(key)
    options = ["--results", str(folder.results)]
    assert main(["status", str(folder.file), *options, "--watch", "5"]) == 0
    assert "5 points: 5 done" in capsys.readouterr().out
    assert main(["status", str(folder.file), *options, "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"]["done"] == 5


def test_the_study_is_the_default_one_when_none_is_named(tmp_path, capsys):
    assert main(["status", "--results", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("quick: ")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.yaml"], "none.yaml: no such file"),
        (["--watch", "0"], "--watch: got 0; allowed: a number in [1, 86400]"),
        (["--watch", "nan"], "--watch: got nan; allowed: a number in [1, 86400]"),
        (["--results", "README.md"], "README.md is not a folder"),
    ],
)
def test_mistakes_give_one_line(arguments, words, capsys):
    assert main(["status", *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and words in line


@pytest.mark.parametrize("content", ["[", "[1]", '{"extra": {"system": "chute", "depth": -1}}'])
def test_an_unreadable_round_gives_one_line(tmp_path, capsys, content):
    folder = Folder(tmp_path, BOUNDED)
    rounds = folder.results / "made" / "rounds"
    rounds.mkdir(parents=True)
    (rounds / "1.json").write_text(content)
    assert main(["status", str(folder.file), "--results", str(folder.results)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "1.json" in line


def test_a_killed_run_was_interrupted(tmp_path):
    text = "study: made\nseries: [{name: a, system: belt, base: {frequency: 20, average: 1.0e+5}}]"
    folder = Folder(tmp_path, text)
    (key,) = folder.ids
    point = folder.study.points[key].parameters
    warm([point])
    folder.runs.mkdir(parents=True)
    output = folder.runs / f"{key}.nc"
    process = subprocess.Popen(
        [sys.executable, "-m", "sim", "run", "-", "-o", str(output)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        process.stdin.write(json.dumps(canonical(point)))
        process.stdin.close()
        limit = time.monotonic() + 60
        while not ((said := read_progress(output)) and said.done > 1e5):
            assert process.poll() is None and time.monotonic() < limit
            time.sleep(0.05)
        running = folder.survey()
        assert running.counts["running"] == 1
        assert running.left > 0 and said.rate > 1e6
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert folder.state(key) == "interrupted"
    assert "interrupted" in as_text(folder.survey())
