"""How far a study is, told from made-up folders and from a run that is killed."""

import json
import os
import signal
import subprocess
import sys

import pytest

from sim.engine.command import warm
from sim.engine.identity import NUMERICS
from sim.engine.progress import read_progress
from sim.parameters import canonical_values, parse_point, point_id
from sim.report.status import STATES
from sim.report.status_table import as_json, as_text
from sim.study.cost import PROCESS_TIME, estimate
from tests.made.folder import BOUNDED, EARLIER, LATER, STUDY, Folder
from tests.made.processes import start_run, wait_until
from tests.made.runs import FAILURE, write_run


@pytest.fixture
def folder(tmp_path) -> Folder:
    return Folder(tmp_path)


def test_a_study_that_was_not_started_waits(folder):
    status = folder.survey()
    assert status.counts == dict.fromkeys(STATES, 0) | {"waiting": 5}
    cost = sum(estimate(point.parameters).core_seconds for point in folder.study.points.values())
    assert status.core_seconds_left == pytest.approx(cost)
    assert status.seconds_left is None and not status.is_over
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


@pytest.mark.parametrize("content", [b"", b"\x89HDF", b'{"point": "x"', b"{}", b"[3]"])
def test_a_progress_file_that_says_nothing_is_none(folder, content):
    folder.write_progress(folder.ids[0]).write_bytes(content)
    assert folder.state(folder.ids[0]) == "waiting"


@pytest.mark.parametrize(
    "forged",
    [
        {"updated": "0001-01-01T00:00:00+00:00", "host": "elsewhere"},
        {"expires": "9999-12-31T23:59:59+00:00"},
        {"rate": 1e300},
        {"total": 10**400},
    ],
)
def test_a_progress_file_that_no_run_has_written_is_none(forged, folder):
    path = folder.write_progress(folder.ids[0])
    path.write_text(json.dumps(json.loads(path.read_text()) | forged))
    assert folder.state(folder.ids[0]) == "waiting"


def test_a_time_left_beyond_all_measure_is_unknown(folder):
    folder.write_progress(folder.ids[0], rate=1e-300)
    status = folder.survey()
    assert status.points[folder.ids[0]].progress.remaining_time == "unknown"
    assert "inf" not in as_text(status)


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


def test_a_file_that_changes_is_read_again(folder):
    key = folder.ids[0]
    os.utime(folder.finish(key), ns=(1, 1))
    assert folder.state(key) == "done"
    os.utime(folder.finish(key, failed=[0]), ns=(2, 2))
    assert folder.state(key) == "failed"


def test_runs_of_other_numerics_are_counted(folder):
    folder.finish(folder.ids[0], numerics=NUMERICS + 1)
    folder.finish(folder.ids[1])
    status = folder.survey()
    assert [point.outdated for point in status.points.values()] == [True, *[False] * 4]
    assert "to be run again: 1 point" in as_text(status)


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
        folder.write_progress(key)
    for key in folder.ids[2:]:
        folder.finish(key)
    status = folder.survey()
    # 500 steps of 100 particles at 5,000 particle-steps per second.
    assert (status.cores, status.core_seconds_left, status.seconds_left) == (2, 20.0, 10.0)
    assert "time left about 10.0 s on 2 cores" in as_text(status)
    folder.write_progress(folder.ids[0], done=0)
    assert folder.survey().seconds_left == 20.0


def test_time_left_of_runs_that_may_end_early_is_a_bound(tmp_path):
    text = STUDY.replace("title:", "defaults: {chute: {protocol: converged}}\ntitle:")
    folder = Folder(tmp_path, text)
    assert "left at most" in as_text(folder.survey())
    folder.finish(folder.ids[0])
    assert "left about" in as_text(folder.survey())
    folder.write_progress(folder.ids[1], at_most=True)
    text = as_text(folder.survey())
    assert "time left at most" in text and "at most 10.0 s" in text


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
        assert running.seconds_left > 0 and running.points[key].progress.rate > 0
    finally:
        process.send_signal(signal.SIGKILL)
        process.communicate()
    assert folder.state(key) == "interrupted"
    assert "interrupted" in as_text(folder.survey())
