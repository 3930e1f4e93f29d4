"""Messages of a workflow before it starts: mistakes in one line, and the default study."""

import subprocess
import sys

import pytest

from tests.made.processes import ROOT
from tests.made.project import bare_folder, snakemake


def refusal_line(process: subprocess.CompletedProcess) -> str:
    """Return the one line with which a workflow refuses to start."""
    assert process.returncode == 2
    (line,) = (line for line in process.stderr.splitlines() if "profile" not in line)
    return line


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("study: bad\nseries: [{name: a, system: chute, base: {restitution: 0}}]\n", "restitution"),
        ("study: bad\nsurprise: 1\n", "surprise"),
    ],
)
def test_a_bad_study_gives_one_line_and_no_work(tmp_path, content, words):
    (tmp_path / "bad.yaml").write_text(content)
    line = refusal_line(snakemake(tmp_path, study="bad.yaml"))
    assert line.startswith("error: bad.yaml: ")
    assert words in line
    assert not (tmp_path / "results").exists()


def test_single_values_cannot_be_overridden_behind_the_study(tmp_path):
    process = snakemake(bare_folder(tmp_path), "-n", "--config", "title=other")
    assert refusal_line(process).startswith("error: --config")


def test_a_bad_environment_gives_one_line_and_no_work(tmp_path, monkeypatch):
    monkeypatch.setenv("TALUS_CHECKPOINT_SECONDS", "abc")
    line = refusal_line(snakemake(bare_folder(tmp_path)))
    assert line.startswith("error: environment: TALUS_CHECKPOINT_SECONDS: got 'abc'")


def test_the_default_study_is_the_quick_one(tmp_path):
    (tmp_path / "config").symlink_to(ROOT / "config")
    snakefile = str(ROOT / "Snakefile")
    options = ["-n", "--quiet", "host", "--snakefile", snakefile]
    command = [sys.executable, "-m", "snakemake", *options]
    dry_run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert dry_run.returncode == 0, dry_run.stderr
    assert "results/quick/report.html" in dry_run.stdout + dry_run.stderr
    assert "results/tiny" not in dry_run.stdout + dry_run.stderr


def test_lint_finds_nothing():
    lint = subprocess.run(
        [sys.executable, "-m", "snakemake", "--lint"], cwd=ROOT, capture_output=True, text=True
    )
    assert lint.returncode == 0, lint.stderr
