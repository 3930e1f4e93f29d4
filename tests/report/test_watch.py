"""What a workflow shows while it runs: a line per failed point, and how many there are."""

import logging
import os
import re
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

from sim.base.errors import InputError
from sim.report.preview import write
from sim.report.watch import FIRST, SHARE, FailedJobs, Previews, Watch
from sim.study.load import load_study
from tests.made.folder import Folder

STUDY = """\
study: watched
series: [{name: beds, system: belt, grid: {frequency: [20, 40, 60]}}]
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "watched.yaml").write_text(STUDY)
    return load_study(tmp_path / "watched.yaml", tmp_path)


def finish(folder, name, *lines):
    """Write what a run leaves: its log and its file."""
    for part in ("runs", "logs/runs"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    said = "".join(f"{name}: {line}\n" for line in lines)
    (folder / "logs" / "runs" / f"{name}.log").write_text(f"{said}{folder}: written\n")
    (folder / "runs" / f"{name}.nc").touch()


def test_each_point_that_fails_is_told_once_with_its_reason_and_counted_in_a_bar(
    study, tmp_path, monkeypatch, capsys
):
    there, failing, flowing = study.points
    finish(tmp_path, there, "failed: long ago")
    for is_terminal in (False, True):
        monkeypatch.setattr("sys.stderr.isatty", lambda told=is_terminal: told, raising=False)
        watch = Watch(study, tmp_path)
        watch.start()
        finish(tmp_path, failing, "200 particles", "failed: an overlap")
        finish(tmp_path, flowing, "200 particles", "velocity 2 m/s")
        watch.end()
        output = capsys.readouterr().err
        assert f"{failing}: failed: an overlap\n" in output and "long ago" not in output
        bar = re.search(r"watched: 3 of 3 points \|.*\| .* left, 1 failed", output)
        assert bool(bar) == is_terminal
        for key in (failing, flowing):
            (tmp_path / "runs" / f"{key}.nc").unlink()


def fail(log, *logs, message=None):
    """Let a log say, as Snakemake does, that a job has failed."""
    told = {
        "event": "job_error",
        "rule_name": "run",
        "rule_msg": message,
        "log": list(map(str, logs)),
    }
    log.error("Error in rule run, jobid: 3", extra=told)


SAID, NOTICE = (
    "first\nerror: no space\n",
    "plug-in /a/base_slip.py (1a2b3c4d): observable base_slip\n",
)


@pytest.mark.parametrize(
    ("said", "age", "cluster", "message", "line"),
    [
        # File systems may keep whole seconds; an older log is of an earlier attempt.
        (SAID, 1, None, None, "error: no space"),
        (SAID, 1e6, None, None, "see dataset.log"),
        (
            "point: terminated\n",
            0,
            "a page\n",
            "status is: 'TIMEOUT'. For further error details see",
            "status is: 'TIMEOUT': point: terminated",
        ),
        (None, 0, "a page\n", "status is: 'NODE_FAIL'.", "status is: 'NODE_FAIL': see 7.log"),
        (None, 0, None, "refused\n    sbatch call: ...", "refused"),
        ("", 0, None, "refused", "refused"),
        # A job that is stopped has said nothing but which plug-ins it has loaded.
        (NOTICE, 0, None, None, ""),
        (SAID + NOTICE, 0, None, None, "error: no space"),
    ],
)
def test_a_failed_job_is_one_line(tmp_path, monkeypatch, said, age, cluster, message, line):
    monkeypatch.chdir(tmp_path)
    lines, log = [], logging.Logger("snakemake")
    log.addHandler(FailedJobs(lines.append))
    texts = {"dataset.log": said} | ({"7.log": cluster} if cluster else {})
    for name, text in texts.items():
        if text is not None:
            Path(name).write_text(text)
    if said:
        os.utime("dataset.log", (int(time.time()) - age,) * 2)
    fail(log, *texts, message=message)
    log.info("Select jobs to execute...")
    assert lines == [": ".join(filter(None, ("dataset: job failed", line)))]


@pytest.mark.parametrize("age", [None, -1, 1])
def test_a_workflow_ends_with_failed_jobs_the_status_and_a_report_no_older_than_the_dataset(
    study, tmp_path, monkeypatch, capsys, age
):
    log, folder = logging.Logger("snakemake"), tmp_path / study.name
    watch = Watch(study, folder)
    watch.follow(log)
    noise = (
        "Cannot restore results/a.nc: no backup found.",
        "RuleException:\nCalledProcessError in file run.smk, line 20:\nCommand ...",
        "Execute 3 jobs...",
    )
    for text in noise:
        log.error(text)
    fail(log)
    folder.mkdir()
    for name, date in (("dataset.nc", 1), ("report.html", 1 + age)) if age else ():
        (folder / name).touch()
        os.utime(folder / name, (date, date))
    watch.summarize()
    output = capsys.readouterr().err
    assert "run: job failed" in output and not any(text[:9] in output for text in noise)
    assert "\n3 points: " in output
    assert output.endswith(f"\nreport: {folder}/report.html\n") == (age == 1)
    # An unreadable folder leaves only the status out.
    monkeypatch.setattr("sim.report.watch.survey", Mock(side_effect=PermissionError("runs")))
    Watch(study, tmp_path).summarize()
    assert "no summary: runs" in capsys.readouterr().err


def test_previews_are_one_at_a_time_seldom_and_never_of_a_study_that_has_ended(
    study, tmp_path, monkeypatch
):
    (tmp_path / "logs").mkdir()
    now, started = [0.0], []
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    monkeypatch.setattr(
        "subprocess.Popen", lambda *words, **_: started.append(Mock()) or started[-1]
    )
    previews = Previews(study, tmp_path)

    def update(time, ended, running=None):
        now[0] = time
        if started:
            started[-1].poll.return_value = None if running else 0
        previews.update(ended)
        return len(started)

    assert update(FIRST - 1, 1) == 0
    assert update(FIRST, 0) == 0
    assert update(FIRST, 1) == 1
    assert update(FIRST + 5, 2, running=True) == 1
    assert update(FIRST + 10, 2) == 1
    assert update(FIRST + 10 + 10 / SHARE - 1, 2) == 1
    assert update(FIRST + 10 + 10 / SHARE, 1) == 1
    assert update(FIRST + 10 + 10 / SHARE, 2) == 2
    assert update(FIRST + 11 + 10 / SHARE, len(study.points), running=True) == 2
    started[-1].kill.assert_called_once()


def test_a_preview_has_the_points_that_have_ended_and_is_older_than_all(tmp_path):
    folder = Folder(tmp_path)
    with pytest.raises(InputError, match="no point has a run file"):
        folder.results.joinpath("made").mkdir(parents=True)
        write(folder.file, folder.results)
    for key in folder.ids[:2]:
        run = folder.finish(key)
    page = write(folder.file, folder.results)
    assert "Not complete: 2 of 5 points have ended." in page.read_text("utf-8")
    assert page == folder.results / "made" / "report.html"
    assert page.stat().st_mtime < run.stat().st_mtime
    assert {path.name for path in page.parent.iterdir()} == {"runs", "report.html"}
