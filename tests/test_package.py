"""What is installed: the package with all files that it reads, and what `make setup` says."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
import venv
from pathlib import Path

import pytest

from sim import __version__
from tests.made.processes import ROOT, program
from tests.made.project import copy_tree, jobs, planned_jobs

LISTED = """\
from setuptools.dist import Distribution
made = Distribution({"script_name": "setup.py"})
made.parse_config_files()
command = made.get_command_obj("build_py")
command.ensure_finalized()
command.build_lib = "."
print(*command.get_outputs(include_bytecode=False), sep="\\n")
"""

STUDY = """\
study: installed
defaults: {belt: {transient: 1, average: 1, beads: 20, width: 6}}
series:
  - {name: one, system: belt, grid: {frequency: [20, 30]}, figures: [gallas_1a]}
"""


def files(folder: str, to: str) -> set[Path]:
    """Return where the files of a folder of the repository are in the package."""
    found = (path for path in (ROOT / folder).rglob("*") if path.is_file())
    return {
        to / path.relative_to(ROOT / folder) for path in found if "__pycache__" not in path.parts
    }


def test_the_package_holds_all_files_of_sim_workflow_and_config():
    pytest.importorskip("setuptools", minversion="77")
    said = subprocess.check_output([sys.executable, "-c", LISTED], cwd=ROOT, text=True)
    workflow, config = files("workflow", "sim/workflow"), files("config", "sim/config")
    assert set(map(Path, said.splitlines())) == (
        files("sim", "sim") | workflow | config | {Path("talus.py")}
    )


def imported(code: str, folder: Path, *places: Path) -> subprocess.CompletedProcess[str]:
    """Run Python code in a folder, with places to import from."""
    settings = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, places))}
    words = [sys.executable, "-c", code]
    return subprocess.run(words, cwd=folder, env=settings, capture_output=True, text=True)


def test_talus_is_the_package_under_its_own_name(tmp_path):
    code = "import talus, sim; from talus import InputError; print(talus is sim, talus.__version__)"
    assert imported(code, tmp_path, ROOT).stdout.split() == ["True", __version__]
    # A module is one, whichever name it is imported by, and none is made up.
    code = "import sim.base.errors as e, talus.base.errors as f; print(e is f, e.__spec__.name)"
    assert imported(code, tmp_path, ROOT).stdout.split() == ["True", "sim.base.errors"]
    error = imported("import talus.nothing", tmp_path, ROOT).stderr
    assert error.splitlines()[-1].startswith("ModuleNotFoundError")
    words = [sys.executable, "-m", "talus", "--version"]
    settings = os.environ | {"PYTHONPATH": str(ROOT)}
    said = subprocess.check_output(words, cwd=tmp_path, env=settings, text=True)
    assert __version__ in said


@pytest.mark.parametrize("foreign", ["sim.py", "sim/__init__.py", "sim/other.py"])
def test_a_foreign_package_of_the_same_name_is_one_clear_error(tmp_path, foreign):
    path = tmp_path / "theirs" / foreign
    path.parent.mkdir(parents=True)
    path.touch()
    only_talus = tmp_path / "only"
    only_talus.mkdir()
    shutil.copy(ROOT / "talus.py", only_talus)
    error = imported("import talus", tmp_path, tmp_path / "theirs", only_talus).stderr
    assert error.splitlines()[-1].startswith("ImportError: ")
    assert str(tmp_path / "theirs" / "sim") in error.splitlines()[-1]
    assert "another package is called sim" in error


def test_the_version_is_the_same_wherever_it_is_said():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["version"] == __version__


def test_the_least_python_is_said_before_pip_looks_for_packages():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    least = project["requires-python"].removeprefix(">=")
    older = f"import sys; sys.version_info = (3, {int(least.split('.')[1]) - 1})"
    error = imported(f"{older}; exec(open({str(ROOT / 'setup.py')!r}).read())", ROOT).stderr
    assert error.startswith(f"Talus needs Python {least} or newer")


def test_the_workflow_makes_the_same_alone_and_from_the_root(tmp_path):
    """The package has it without the Snakefile of the root, and a command that runs it."""
    alone = ("--snakefile", str(ROOT / "workflow" / "Snakefile"))
    for figures in ("[]", "[gallas_1a]"):
        (tmp_path / "study.yaml").write_text(STUDY.replace("[gallas_1a]", figures))
        planned = planned_jobs(tmp_path, study="study.yaml")
        assert planned["report"] == planned["warm"] == 1
        assert planned_jobs(tmp_path, *alone, study="study.yaml") == planned
    words = ["-m", "sim", "study", "study.yaml", "--cores", "2", "--", "-n", "--quiet", "host"]
    settings = os.environ | {"PYTHONPATH": str(ROOT)}
    said = subprocess.check_output([sys.executable, *words], cwd=tmp_path, env=settings, text=True)
    assert jobs(said) == planned


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Build the wheel from a copy of the repository; return it."""
    copy = copy_tree(tmp_path_factory.mktemp("copy"))
    for name in ("README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    build = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation"]
    subprocess.run([*build, "--wheel-dir", copy / "dist", copy], check=True, capture_output=True)
    (made,) = (copy / "dist").glob("talus-*.whl")
    return made


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory) -> Path:
    """Install the locked packages and the wheel into an environment of their own; return it."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    pip = [folder / "bin" / "python", "-m", "pip", "install", "--quiet", "--no-compile"]
    subprocess.run([*pip, "--requirement", ROOT / "requirements.lock"], check=True)
    subprocess.run([*pip, "--no-deps", wheel], check=True)
    return folder


@pytest.fixture
def talus(environment, tmp_path, monkeypatch):
    """Call the installed command in an empty folder, with nothing of the repository in sight."""
    monkeypatch.chdir(tmp_path)
    settings = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    settings["PATH"] = f"{environment / 'bin'}:/usr/bin:/bin"

    def call(*words: str) -> str:
        done = subprocess.run(["talus", *words], env=settings, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout + done.stderr

    return call


@pytest.mark.long
def test_a_study_runs_in_an_empty_folder_from_the_built_wheel(talus, environment, wheel):
    assert "usage: talus" in talus("--help")
    assert "9 points" in talus("init", "mine.yaml") + talus("points", "mine.yaml")
    assert "report" in talus("study", "mine.yaml", "--", "-n")
    Path("installed.yaml").write_text(STUDY)
    # What lies there is not imported instead.
    Path("sim").mkdir()
    Path("sim", "__init__.py").write_text("raise ImportError")
    talus("study", "installed.yaml", "--cores", "2")
    counts = json.loads(talus("status", "installed.yaml", "--format", "json"))["counts"]
    assert counts["done"] == 2 and not counts["failed"]
    assert Path("results/installed/report.html").is_file()
    assert Path("results/installed/figures/gallas_1a.svg").is_file()
    assert nothing_to_do(talus)

    # The repository itself, installed to be edited, is the same program.
    pip = [environment / "bin" / "python", "-m", "pip", "install", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--editable", wheel.parents[1]], check=True)
    assert "9 points" in talus("points", "mine.yaml")
    assert nothing_to_do(talus)


def nothing_to_do(talus) -> bool:
    return "Nothing to be done" in talus("study", "installed.yaml", "--", "-n", "--quiet", "host")


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_the_shell_completes_commands_and_files(shell, capsys):
    from sim.__main__ import main

    with pytest.raises(SystemExit) as ended:
        main(["--print-completion", shell])
    script = capsys.readouterr().out
    assert ended.value.code == 0 and "_TALUS_COMPLETE" in script
    asked = {"_TALUS_COMPLETE": f"{shell}_complete", "COMP_WORDS": "talus st", "COMP_CWORD": "1"}
    said = program(env=os.environ | asked).stdout
    assert "status" in said and "study" in said and "points" not in said


PYTHON = """\
#!/bin/sh
if [ "$1 $2" = "-m venv" ]; then mkdir -p "$3/bin" && cp "$0" "$3/bin/python"; fi
"""


@pytest.mark.skipif(shutil.which("make") is None, reason="no make installed")
def test_setup_says_how_to_enter_the_environment_once_it_is_made(tmp_path):
    python = tmp_path / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)
    command = ["make", "-C", ROOT, "setup", f"PYTHON={python}", f"VENV={tmp_path / 'venv'}"]
    first, again = (
        subprocess.run(command, capture_output=True, text=True, check=True) for _ in range(2)
    )
    assert f"ready: . {tmp_path / 'venv'}/bin/activate\n" in first.stdout
    assert "ready" not in again.stdout
