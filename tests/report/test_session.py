"""What a workflow prints, from its start to its end."""

import logging
from unittest.mock import Mock

import pytest

from sim.report.session import Session
from sim.study.load import load_study

STUDY = """\
study: shown
series: [{name: beds, system: belt, grid: {frequency: [20, 40, 60]}}]
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shown.yaml").write_text(STUDY)
    return load_study("shown.yaml")


@pytest.fixture
def log():
    return logging.Logger("snakemake")


def test_a_session_tells_failed_jobs_and_ends_with_the_status(study, log, tmp_path, capsys):
    session = Session(study, tmp_path / "results" / "shown", (), log)
    log.error("Execute 3 jobs...")
    fields = {"event": "job_error", "log": [], "rule_name": "run", "rule_msg": ""}
    log.error("failed", extra=fields)
    session.end()
    output = capsys.readouterr().err
    assert "run: job failed" in output and "Execute" not in output
    assert "\n3 points: " in output


def test_adopted_points_are_not_waited_for(study, log, tmp_path):
    session = Session(study, tmp_path / "results" / "shown", tuple(study.points)[:2], log)
    assert session._watch._estimates.keys() == set(tuple(study.points)[2:])
    session.end()


def test_an_unreadable_folder_leaves_only_the_status_out(study, log, tmp_path, monkeypatch, capsys):
    session = Session(study, tmp_path / "results" / "shown", (), log)
    monkeypatch.setattr("sim.report.session.survey", Mock(side_effect=PermissionError("runs")))
    session.end()
    assert "no summary: runs" in capsys.readouterr().err
