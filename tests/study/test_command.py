"""A study file to start from, and the command that becomes Snakemake."""

import os
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sim.__main__ import main
from sim.base.errors import InputError
from sim.base.program import package_folder
from sim.claims.sources import require_plugins
from sim.study import command
from sim.study.load import DEFAULT_STUDY, load_study
from tests.made.processes import ROOT, plugin_claims, restore_plugins, wait_until

MERGED = "study: merged\na: &a {x: 1}\n" + "".join(
    f"b{n}: &b{n} {{<<: [{', '.join([f'*b{n - 1}' if n else '*a'] * 9)}]}}\n" for n in range(9)
)


class ExecCalled(Exception):
    """``os.execve`` was called."""


@pytest.fixture
def exec_call(tmp_path, monkeypatch) -> list:
    """Return the arguments of ``os.execve``, empty until it is called, in a temporary folder."""
    monkeypatch.chdir(tmp_path)
    call: list = []

    def execve(*arguments):
        call[:] = arguments
        raise ExecCalled

    monkeypatch.setattr(os, "execve", execve)
    return call


@pytest.mark.parametrize(
    ("words", "path", "model"),
    [
        ("", "first.yaml", "first"),
        ("own.yaml", "own.yaml", "first"),
        ("a/b", "a/b/first.yaml", "first"),
        ("mine.yml --from quick", "mine.yml", "quick"),
    ],
)
def test_a_study_of_the_program_is_copied_under_the_name_of_the_file(
    words, path, model, exec_call, capsys
):
    assert main(["init", *words.split()]) == 0
    assert capsys.readouterr().out.startswith(f"{path}: written; ")
    text = Path(path).read_text(encoding="utf-8")
    own, shipped = load_study(path), load_study(package_folder("config") / f"{model}.yaml")
    assert own.name == Path(path).stem and own.points == shipped.points and own.figures
    assert f"talus points {Path(path).name}" in text or path.endswith(".yml")
    schema = text.splitlines()[0].partition("$schema=")[2]
    assert Path(schema) == package_folder("config") / "schema.json"


def test_a_paper_of_ones_own_begins_with_files_that_are_right(exec_call, capsys):
    with restore_plugins():
        assert main(["init", "--paper", "incline", "a"]) == 0
        assert capsys.readouterr().out.startswith("a/incline.yaml and a/incline: written; ")
        assert {path.name for path in Path("a/incline").iterdir()} == {
            *("__init__.py", "paper.yaml", "figures.yaml", "claims.yaml", "judges.py")
        }
        assert not [path for path in Path("a").rglob("*.*") if "mine" in path.read_text()]
        study = load_study("a/incline.yaml")
        assert study.paper == "incline" and list(study.figures) == ["incline_velocity"]
        require_plugins(study.plugins)
        (claim,) = plugin_claims(["chute"])
        assert claim.id == "incline_steeper" and claim.figures == [*study.figures]
    Path("b").mkdir()
    Path("b/incline.yaml").write_text("mine")
    for folder in "ab":
        before = {path: path.read_bytes() for path in Path(folder).rglob("*.*")}
        assert main(["init", "--paper", "incline", folder]) == 2
        assert "incline" in (told := capsys.readouterr().err) and "is there already" in told
        assert before == {path: path.read_bytes() for path in Path(folder).rglob("*.*")}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        *((["--paper", one], "--paper: got ") for one in ("walton", "own", "A", "a.b", "a" * 31)),
        (["--paper", "a", "first.yaml"], "init: got 'first.yaml'; allowed: a folder"),
        ([], "first.yaml: is there already"),
        (["--from", "paper"], "--from: got 'paper'; allowed: one of beyond, explore, first, "),
        (["a b.yaml"], "init: got 'a b.yaml'; allowed: "),
        ([f"{'a' * 61}.yaml"], "init: got "),
        (["x.YAML"], "init: got 'x.YAML'; allowed: "),
        ([".yaml"], "init: got '.yaml'; allowed: "),
        (["first.yaml/x"], "init: got 'first.yaml/x'; allowed: a folder that can be written"),
    ],
)
def test_what_cannot_be_written_is_refused(words, message, exec_call, capsys):
    Path("first.yaml").write_text("mine")
    assert main(["init", *words]) == 2
    assert capsys.readouterr().err.startswith(f"error: {message}")
    assert Path("first.yaml").read_text() == "mine" and len(list(Path().iterdir())) == 1


def test_a_study_is_run_by_the_workflow_of_the_package(exec_call):
    main(["init"])
    with pytest.raises(ExecCalled):
        main(["study", "first.yaml", "--cores", "3", "--", "-n", "figures"])
    program, words, _ = exec_call
    assert program == words[0] == sys.executable
    options = " ".join(words)
    assert "-m snakemake --cores 3 --configfile first.yaml --snakefile " in options
    assert Path(words[words.index("--snakefile") + 1]).is_file()
    assert words[-2:] == ["-n", "figures"]
    slurm = str(package_folder("workflow") / "profiles" / "slurm")
    for name, profile in (("slurm", slurm), ("mine/own", "mine/own")):
        with pytest.raises(ExecCalled):
            main(["study", "first.yaml", "--profile", name])
        assert exec_call[1][-2:] == ["--profile", profile]
        # It would limit the cores of a cluster, too.
        assert "--cores" not in exec_call[1]


def test_a_study_file_is_no_option_and_no_pipe(exec_call, capsys):
    main(["init"])
    Path("first.yaml").rename("--x.yaml")
    with pytest.raises(ExecCalled):
        main(["study", "./--x.yaml"])
    assert "--cores all --configfile ./--x.yaml --snakefile" in " ".join(exec_call[1])
    for words, message in (
        (["-"], "study: got '-'; allowed: a file"),
        (["./--x.yaml", "--cores", "0"], "--cores: got 0; allowed: an integer >= 1"),
    ):
        assert main(["study", *words]) == 2
        assert capsys.readouterr().err.startswith(f"error: {message}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        *(("study: [", "line 2"), ("study: x\n", "series: "), (MERGED, "own.yaml: ")),
        ("base: {friction: 0,3}\n", "expected text as a key; a number has a decimal point"),
    ],
)
def test_mistakes_are_told_before_snakemake_reads_anything(text, message, exec_call, capsys):
    Path("own.yaml").write_text(text)
    assert main(["study", "own.yaml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and message in line
    assert not exec_call


def test_what_containers_lack_is_given_to_snakemake(exec_call, monkeypatch, tmp_path):
    def raise_no_user():
        raise OSError("No username set in the environment")

    main(["init"])
    monkeypatch.setattr(command.getpass, "getuser", raise_no_user)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", "")
    with pytest.raises(ExecCalled):
        main(["study", "first.yaml"])
    environment = exec_call[2]
    assert environment["USER"] == f"user{os.geteuid()}"
    cache = Path(environment["XDG_CACHE_HOME"])
    assert cache.parent == tmp_path and cache.stat().st_mode & 0o777 == 0o700
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    assert command.environment() == os.environ


def test_a_workflow_runs_the_one_study_file_that_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command.study_path([], []) == DEFAULT_STUDY
    for file, path in ((tmp_path / "a" / "b.yaml", "a/b.yaml"), ("/b.yaml", "/b.yaml")):
        assert command.study_path([file], []) == Path(path)
    for files, message in ((["a"], "--config: not used"), (["a", "b"], "--configfile: several")):
        with pytest.raises(InputError, match=f"^{message}"):
            command.study_path(files, ["x=1"] * (len(files) == 1))


@pytest.mark.parametrize("own_interpreter", [False, True])
def test_jobs_find_package_study_and_interpreter(own_interpreter, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "mine")
    path = tmp_path / "{x} 'y'" / "first.yaml"
    path.parent.mkdir()
    shutil.copy(package_folder("config") / "first.yaml", path)
    line = command.job_environment(load_study(path, None), Path("/a b"), own_interpreter)
    names = ["PYTHONPATH", "TALUS_STUDY", "PYTHONSAFEPATH", "TALUS_PLUGINS"]
    show = [sys.executable, "-c", f"import os; print(*map(os.environ.get, {names}), sep='\\n')"]
    output = subprocess.check_output(["bash", "-c", line + shlex.join(show)], text=True)
    package = "/a b" if own_interpreter else "/a b:mine"
    assert output.splitlines() == [package, str(path), "1", "None"]
    assert (f"PATH={Path(sys.executable).parent}" in line) != own_interpreter


#: A child that says which signals it and a process of its own get, and ends a little later; and a
#: process that runs it as `decide` runs Snakemake.
CHILD = """\
import os, signal, subprocess, sys, time
def note(name):
    open(name, "a").close()
role = sys.argv[1]
for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
    signal.signal(number, lambda number, _: note(f"{role}-{number}"))
job = role == "child" and subprocess.Popen([sys.executable, __file__, "job"])
note(f"{role}-ready")
while not os.path.exists("end"):
    time.sleep(0.01)
note(f"{role}-ended")
sys.exit(job.wait() if job else 0)
"""
PARENT = """\
import sys
from sim.study.command import run_with_signals
sys.exit(run_with_signals([sys.executable, "child.py", "child"]))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_signal_is_handed_on_and_the_end_is_waited_for(number, tmp_path):
    """As from a terminal, jobs get interrupts and hang-ups, too."""
    roles = {"child"} if number == signal.SIGTERM else {"child", "job"}
    (tmp_path / "child.py").write_text(CHILD)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    process = subprocess.Popen([sys.executable, "-c", PARENT], cwd=tmp_path, env=environment)

    def has(*names: str) -> bool:
        return all((tmp_path / name).exists() for name in names)

    wait_until(lambda: has("child-ready", "job-ready"), process)
    process.send_signal(number)
    wait_until(lambda: has(*(f"{role}-{number:d}" for role in roles)), process)
    assert process.poll() is None
    (tmp_path / "end").touch()
    assert process.wait() == 128 + number
    assert has("child-ended", "job-ended")
    assert len(list(tmp_path.glob(f"*-{number:d}"))) == len(roles)


def test_the_exit_code_of_the_command_is_kept():
    for code, text in ((3, "raise SystemExit(3)"), (128 + 6, "import os; os.abort()")):
        assert command.run_with_signals([sys.executable, "-c", text]) == code
