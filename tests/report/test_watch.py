"""What a workflow shows while it runs: a line per failed point, and how many there are."""

import logging
import os
import re
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

from sim.report.watch import FailedJobs, Watch, is_news
from sim.study.load import load_study

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


def test_each_point_that_fails_is_told_once_with_its_reason(study, tmp_path, capsys):
    there, failing, flowing = study.points
    finish(tmp_path, there, "failed: long ago")
    watch = Watch(study, tmp_path)
    watch.start()
    finish(tmp_path, failing, "200 particles", "failed: an overlap")
    finish(tmp_path, flowing, "200 particles", "velocity 2 m/s")
    watch.end()
    assert capsys.readouterr().err == f"{failing}: failed: an overlap\n"


def test_a_terminal_has_a_bar_with_the_points_that_have_finished(
    study, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    watch = Watch(study, tmp_path)
    failing, other, _ = study.points
    finish(tmp_path, failing, "failed: an overlap")
    (tmp_path / "runs" / f"{other}.nc").touch()
    watch.end()
    assert re.search(r"watched: 2 of 3 points \|.*\| .* left, 1 failed", capsys.readouterr().err)


@pytest.fixture
def lines():
    return []


@pytest.fixture
def log(lines):
    """A log with a handler that writes to `lines`."""
    log = logging.Logger("snakemake")
    log.addHandler(FailedJobs(lines.append))
    log.addFilter(is_news)
    return log


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
        (SAID, 0, None, None, "error: no space"),
        # File systems may keep whole seconds.
        (SAID, 1, None, None, "error: no space"),
        # The log of an earlier attempt.
        (SAID, 1e6, None, None, "see dataset.log"),
        (
            "point: terminated\n",
            0,
            "a page\n",
            "status is: 'TIMEOUT'. For further error details see",
            ("status is: 'TIMEOUT': point: terminated"),
        ),
        (None, 0, "a page\n", "status is: 'NODE_FAIL'.", "status is: 'NODE_FAIL': see 7.log"),
        (None, 0, None, "refused\n    sbatch call: ...", "refused"),
        ("", 0, None, "refused", "refused"),
        # A job that is stopped has said nothing but which plug-ins it has loaded.
        (NOTICE, 0, None, None, ""),
        (SAID + NOTICE, 0, None, None, "error: no space"),
    ],
)
def test_a_failed_job_is_one_line(
    tmp_path, monkeypatch, log, lines, said, age, cluster, message, line
):
    monkeypatch.chdir(tmp_path)
    texts = {"dataset.log": said} | ({"7.log": cluster} if cluster else {})
    for name, text in texts.items():
        if text is not None:
            Path(name).write_text(text)
    if said:
        os.utime("dataset.log", (int(time.time()) - age,) * 2)
    fail(log, *texts, message=message)
    log.info("Select jobs to execute...")
    assert lines == [": ".join(filter(None, ("dataset: job failed", line)))]


@pytest.mark.parametrize(
    ("said", "is_told"),
    [
        ("submitted", True),
        ("Cannot restore results/a.nc: no backup found.", False),
        ("RuleException:\nCalledProcessError in file run.smk, line 20:\nCommand ...", False),
        ("Select jobs to execute...", False),
        ("Execute 2 jobs...", False),
    ],
)
def test_what_the_line_of_a_failed_job_makes_superfluous_is_no_news(log, said, is_told):
    assert is_news(log.makeRecord("", logging.WARNING, "", 0, said, (), None)) == is_told


def test_a_workflow_that_is_followed_tells_failed_jobs_and_ends_with_the_status(
    study, tmp_path, capsys
):
    log, watch = logging.Logger("snakemake"), Watch(study, tmp_path / study.name)
    watch.follow(log)
    log.error("Execute 3 jobs...")
    fail(log)
    watch.summarize()
    output = capsys.readouterr().err
    assert "run: job failed" in output and "Execute" not in output
    assert "\n3 points: " in output and "report" not in output


@pytest.mark.parametrize("age", [-1, 1])
def test_a_workflow_ends_with_the_place_of_a_report_that_is_not_older_than_the_dataset(
    study, tmp_path, capsys, age
):
    folder = tmp_path / study.name
    folder.mkdir()
    for name, date in (("dataset.nc", 1), ("report.html", 1 + age)):
        (folder / name).touch()
        os.utime(folder / name, (date, date))
    Watch(study, folder).summarize()
    ending = f"\nreport: {folder}/report.html\n"
    assert capsys.readouterr().err.endswith(ending) == (age > 0)


def test_an_unreadable_folder_leaves_only_the_status_out(study, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sim.report.watch.survey", Mock(side_effect=PermissionError("runs")))
    Watch(study, tmp_path).summarize()
    assert "no summary: runs" in capsys.readouterr().err
