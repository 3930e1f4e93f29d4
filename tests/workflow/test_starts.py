"""Before a workflow starts and where its jobs run: mistakes in one line, clusters, a container."""

import json
import re
import subprocess
import sys
import tomllib

import pytest
import yaml

from tests.made.processes import ROOT
from tests.made.project import bare_folder, command, jobs, plan, snakemake


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
    dry_run = snakemake(tmp_path, "-n", study="")
    assert dry_run.returncode == 0, dry_run.stderr
    assert "results/quick/report.html" in dry_run.stdout + dry_run.stderr
    assert "results/tiny" not in dry_run.stdout + dry_run.stderr


def test_lint_finds_nothing():
    lint = snakemake(ROOT, "--lint", study="")
    assert lint.returncode == 0, lint.stderr


#: Replaces the program of that name: it logs its arguments, and runs the command with a `python`
#: that only the container has.
APPTAINER = """\
#!/bin/bash
if [ "$1" = --version ]; then echo apptainer version 1.3.0; exit; fi
printf '%s\\n' "${{@:1:$#-1}}" > {log}
export PATH={container}:/usr/bin:/bin
exec /bin/bash -c "${{@: -1}}"
"""


def project() -> dict:
    """Return the table ``project`` of ``pyproject.toml``."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize("study", ["tiny.yaml", "onset.yaml"])
def test_every_job_asks_for_memory_and_run_time(tmp_path, study):
    """A cluster may refuse one that does not, or kill it for what it takes."""
    dry_run = plan(bare_folder(tmp_path, study), study=study)
    jobs = re.findall(r"^(?:rule|checkpoint) (\w+):\n(.*?)(?=^\S|\Z)", dry_run, re.M | re.S)
    assert {"warm", "dataset", "claims", "report"} <= {name for name, _ in jobs}
    for name, description in jobs:
        if name != "default":
            assert re.search(r"\bmem_mb=\d+", description) and re.search(
                r"\bruntime=\d+", description
            ), name


def test_a_failed_job_is_told_in_one_line(tmp_path):
    """Here the point is larger than any machine."""
    (tmp_path / "endless.yaml").write_text(
        "study: endless\nseries: [{name: a, system: belt, base: {width: 1.0e+13}}]\n"
    )
    process = snakemake(tmp_path, "runs", study="endless.yaml")
    assert process.returncode == 1
    (line,) = (line for line in process.stderr.splitlines() if "job failed" in line)
    assert re.match(r"belt-\S+: job failed: error: belt-\S+: cannot be computed: ", line)
    assert "no backup found" not in process.stderr


def test_a_start_beside_earlier_jobs_imports_no_library_of_tables(tmp_path):
    """Nor would it run a job that is done."""
    tree = bare_folder(tmp_path)
    assert snakemake(tree, "warm").returncode == 0
    python, *words = command(tree, "warm", "--dry-run")
    start = [python, "-X", "importtime", *words]
    process = subprocess.run(start, cwd=tree, capture_output=True, text=True)
    assert process.returncode == 0 and not jobs(process.stdout), process.stdout
    modules = re.findall(r"^import time:.*\| +(\S+)$", process.stderr, re.M)
    assert "sim.study.plan" in modules and "pandas" not in modules


def test_commands_run_in_the_container(tmp_path, monkeypatch):
    programs, container, log = tmp_path / "programs", tmp_path / "inside", tmp_path / "told"
    for folder in (programs, container):
        folder.mkdir()
    (container / "python").write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    (programs / "apptainer").write_text(APPTAINER.format(log=log, container=container))
    for program in (container / "python", programs / "apptainer"):
        program.chmod(0o755)
    monkeypatch.setenv("PATH", str(programs), prepend=":")
    process = snakemake(bare_folder(tmp_path), "warm", "--sdm", "apptainer")
    assert process.returncode == 0, process.stderr
    words = log.read_text().splitlines()
    assert words[0] == "exec" and str(ROOT / "talus.sif") in words


def test_the_container_has_the_locked_packages_and_the_python_of_the_golden_bits():
    """The release of Debian decides on Python and C library, and with them on bits."""
    text = (ROOT / "workflow" / "talus.def").read_text(encoding="utf-8")
    sections = dict(re.findall(r"^%(\w+)\n(.*?)(?=^%|\Z)", text, re.M | re.S))
    copied = dict(line.split() for line in sections["files"].strip().splitlines())
    assert all((ROOT / source).is_file() for source in copied)
    assert f"-m pip install --no-cache-dir --requirement {copied['requirements.lock']}\n" in text

    assert re.search(r"^ +from=(.+)$", sections["arguments"], re.M)[1] == "debian:bookworm-slim"
    bits = json.loads((ROOT / "tests" / "golden" / "bits.json").read_text(encoding="utf-8"))
    assert all("glibc-2.36 python-3.11 " in machine for machine in bits)
    assert project()["requires-python"] == ">=3.11"


def test_the_executor_plugin_is_installed_in_the_version_of_the_extra():
    (plugin,) = project()["optional-dependencies"]["slurm"]
    page = ROOT / "docs" / "cluster.md"
    assert f"pip install {plugin}\n" in page.read_text(encoding="utf-8")


def test_the_conda_environment_has_the_versions_of_the_lock_file():
    """Some packages have another name there; the last part of a version may count builds."""
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    locked = dict(line.lower().split("==") for line in lines)
    text = (ROOT / "workflow" / "envs" / "talus.yaml").read_text(encoding="utf-8")
    names = {"freud": "freud-analysis", "matplotlib-base": "matplotlib"}
    for name, version in (line.split("=") for line in yaml.safe_load(text)["dependencies"]):
        if name != "python":
            assert locked[names.get(name, name)].partition(".post")[0] == version, name
