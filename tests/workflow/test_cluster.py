"""Support for clusters: resources of every job, one line for each failed job, a container."""

import json
import re
import sys
import tomllib

import pytest
import yaml

from tests.made.processes import ROOT
from tests.made.project import bare_folder, plan, snakemake

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
