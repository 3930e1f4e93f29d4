"""Elsewhere and for long: a user without a home, other Pythons, ten thousand made-up inputs."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.made.processes import ROOT

#: A user without a name, made from root by `setpriv` of Linux, with the right to read everything.
USER = 61234
READS = "+dac_read_search"
STUDY = """\
study: contained
defaults: {belt: {transient: 1, average: 1, beads: 20, width: 6}}
series: [{name: one, system: belt, grid: {frequency: [20, 30]}}]
"""


@pytest.fixture
def nobody(tmp_path):
    """Run a command as one who may write a folder and nothing else; return what became of it."""
    if os.geteuid() or not shutil.which("setpriv"):
        pytest.skip("only root can be another user")
    folder = tmp_path / "own"
    folder.mkdir()
    for path in (folder, *tmp_path.parents[:2], tmp_path):
        path.chmod(0o755)
    os.chown(folder, USER, USER)

    def run(*command: str, **settings: str) -> subprocess.CompletedProcess:
        own = ["setpriv", f"--reuid={USER}", f"--regid={USER}", "--clear-groups"]
        own += [f"--inh-caps={READS}", f"--ambient-caps={READS}"]
        path = f"{Path(sys.executable).parent}:/usr/bin:/bin"
        environment = {"PATH": path, "HOME": "/nonexistent", "PYTHONPATH": str(ROOT)}
        environment |= {"TMPDIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1"} | settings
        return subprocess.run(
            [*own, *command], cwd=folder, env=environment, capture_output=True, text=True
        )

    done = run("touch", str(ROOT / "mine"))
    if "Permission denied" not in done.stderr:
        pytest.skip(f"no such user can be made: {done.stderr}")
    (folder / "study.yaml").write_text(STUDY)
    (folder / "point.yaml").write_text("{system: belt, transient: 1, average: 1, beads: 20}\n")
    return run


@pytest.mark.long
def test_a_run_needs_neither_name_nor_home(nobody, tmp_path):
    done = nobody(sys.executable, "-m", "sim", "run", "-o", "out.nc", "point.yaml")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("warning") <= 1 and "Traceback" not in done.stderr
    assert (tmp_path / "own" / "out.nc").exists()


@pytest.mark.long
def test_a_study_needs_a_name_and_a_cache_for_snakemake(nobody, tmp_path):
    command = ["snakemake", "--cores", "1", "--configfile", "study.yaml"]
    command += ["--snakefile", str(ROOT / "Snakefile")]
    done = nobody(*command, USER="someone", XDG_CACHE_HOME=str(tmp_path / "own" / "cache"))
    _assert_done(done, tmp_path)


@pytest.mark.long
def test_the_command_gives_snakemake_what_it_needs(nobody, tmp_path):
    done = nobody(sys.executable, "-m", "sim", "study", "study.yaml", "--cores", "1")
    _assert_done(done, tmp_path)


def _assert_done(done: subprocess.CompletedProcess, tmp_path: Path) -> None:
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "2 points: 2 done" in said and "Traceback" not in said
    assert (tmp_path / "own" / "results" / "contained" / "report.html").exists()


#: Pythons under which the suite runs where found; `TALUS_PYTHONS` may name programs between colons.
SUPPORTED = ("3.11", "3.12", "3.13")
HERE = f"{sys.version_info.major}.{sys.version_info.minor}"


def other_pythons() -> list[str]:
    """Programs of other Pythons, the path of each."""
    named = os.environ.get("TALUS_PYTHONS", "")
    if named:
        return named.split(os.pathsep)
    programs = [shutil.which(f"python{one}") for one in SUPPORTED if one != HERE]
    return [path for path in programs if path and not subprocess.run([path, "-V"]).returncode]


@pytest.mark.long
def test_the_suite_passes_under_other_pythons(tmp_path, capsys):
    if not other_pythons():
        pytest.skip("no other supported Python here")
    for python in other_pythons():
        tree = tmp_path / "tree"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(tree)], check=True)
        done = subprocess.run(
            ["make", "test", f"PYTHON={python}"], cwd=tree, capture_output=True, text=True
        )
        told = f"{python}: {done.stdout.strip().splitlines()[-1:]}"
        assert done.returncode == 0, told + done.stdout[-5000:]
        with capsys.disabled():
            print(f"\n{told}")
        shutil.rmtree(tree)


KINDS = ("parameters", "study_files")
FILES = [f"tests/properties/test_{kind}.py" for kind in KINDS]
PASSED = re.compile(r"(\d+) passing")


@pytest.mark.long
def test_points_and_studies_of_all_kinds(capsys):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *FILES]
    command += ["--hypothesis-profile=long", "--hypothesis-show-statistics"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-5000:]
    number = sum(map(int, PASSED.findall(done.stdout)))
    assert number >= 20_000
    with capsys.disabled():
        print(f"\n{number} made-up points and files: each read, or refused in one line")
