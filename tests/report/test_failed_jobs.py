"""A failed job is told in one line, with the last line of its log."""

import logging
import os
import time

import pytest

from sim.report.watch import FailedJobs, is_news


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


def test_what_a_job_said_last_is_told(tmp_path, log, lines):
    said = tmp_path / "dataset.log"
    said.write_text("first\nerror: no space\n")
    fail(log, said)
    log.info("Select jobs to execute...")
    assert lines == ["dataset: job failed: error: no space"]


def test_of_a_job_on_a_cluster_its_state_is_told_too(tmp_path, log, lines):
    said = tmp_path / "batch_1.log"
    said.write_text("point: terminated\n")
    fail(
        log, said, tmp_path / "7.log", message="status is: 'TIMEOUT'. For further error details see"
    )
    assert lines == ["batch_1: job failed: status is: 'TIMEOUT': point: terminated"]


def test_of_a_long_message_the_first_line_is_told(tmp_path, log, lines):
    fail(log, tmp_path / "warm.log", message="refused\n    sbatch call: ...")
    assert lines == ["warm: job failed: refused"]


def test_the_log_of_the_cluster_is_named_where_the_command_had_nothing_to_say(tmp_path, log, lines):
    (tmp_path / "7.log").write_text("a page of text\n")
    fail(log, tmp_path / "none.log", tmp_path / "7.log", message="status is: 'NODE_FAIL'.")
    assert lines == [f"none: job failed: status is: 'NODE_FAIL': see {tmp_path / '7.log'}"]


def test_a_log_of_an_earlier_attempt_is_not_told(tmp_path, log, lines):
    said = tmp_path / "claims.log"
    said.write_text("error: of yesterday\n")
    os.utime(said, (0, 0))
    fail(log, said)
    assert lines == [f"claims: job failed: see {said}"]


def test_a_log_whose_file_system_keeps_coarse_times_is_told(tmp_path, log, lines):
    said = tmp_path / "dataset.log"
    said.write_text("error: no space\n")
    whole_seconds = int(time.time()) - 1
    os.utime(said, (whole_seconds, whole_seconds))
    fail(log, said)
    assert lines == ["dataset: job failed: error: no space"]


def test_no_empty_log_is_named(tmp_path, log, lines):
    empty = tmp_path / "warm.log"
    empty.touch()
    fail(log, empty, message="refused")
    assert lines == ["warm: job failed: refused"]


def test_a_job_without_a_log_is_told_by_its_rule(log, lines):
    fail(log)
    assert lines == ["run: job failed"]


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
