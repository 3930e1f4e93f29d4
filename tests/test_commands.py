"""Every mistake in a study, a point or a folder: one line, exit code 2, nothing computed."""

import os
import re
import subprocess
import sys
from inspect import signature
from pathlib import Path
from pkgutil import resolve_name

import pytest

from sim.__main__ import main
from sim.base.command_line import COMMANDS, EARLIER_NAMES, JOBS, parse
from tests.made.processes import ROOT, program, refusal

STUDY = """\
study: mine
series:
  - name: first
    system: chute
    base: {angle: 17}
    grid:
      depth: [1, 2]
      restitution: [0.7, 0.85, 1]
      friction: [0.3, 0.4]
      stiffness: [100]
    figures: [walton_2]
  - name: second
    system: belt
    cases: [{frequency: 20}]
"""


@pytest.fixture
def refuse(tmp_path, capsys, monkeypatch):
    """Run a command that must be refused, and return its message."""
    monkeypatch.chdir(tmp_path)

    def refuse(*command: str) -> str:
        before = sorted(tmp_path.rglob("*"))
        code = main(command)
        out, err = capsys.readouterr()
        assert code == 2
        assert out == ""
        assert err.startswith("error: ") and err.endswith("\n") and err.count("\n") == 1
        assert sorted(tmp_path.rglob("*")) == before
        return err

    return refuse


@pytest.mark.parametrize("command", [["points"], ["run", "-o", "run.nc"]])
def test_files_that_are_not_there_or_no_text(command, tmp_path, refuse):
    assert "none.yaml: no such file" in refuse(*command, "none.yaml")
    (tmp_path / "folder").mkdir()
    assert "folder: a folder" in refuse(*command, "folder")
    for data in (b"\x89HDF\r\n\x1a\n\xff\xfe", b"study: a\x00b\n"):
        (tmp_path / "mine.yaml").write_bytes(data)
        assert "mine.yaml: not a text file" in refuse(*command, "mine.yaml")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read and write everything")
def test_permissions_are_respected(tmp_path, refuse):
    (tmp_path / "mine.yaml").write_text(STUDY)
    (tmp_path / "results").mkdir(mode=0o500)
    assert "study: got 'results/mine'; allowed: a folder" in refuse("dataset", "mine.yaml")
    (tmp_path / "mine.yaml").chmod(0)
    assert "mine.yaml: cannot be read" in refuse("points", "mine.yaml")


@pytest.mark.parametrize("command", ["dataset", "boundaries", "claims", "report"])
def test_results_that_cannot_be_written(command, tmp_path, refuse):
    (tmp_path / "mine.yaml").write_text(STUDY)
    (tmp_path / "results").write_text("in the way")
    assert "mine.yaml: study: got 'results/mine'; allowed: a folder" in refuse(command, "mine.yaml")


def test_what_only_reads_needs_no_place_to_write(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(STUDY)
    with monkeypatch.context() as patched:
        patched.setattr("tempfile.TemporaryFile", lambda **_: 1 / 0)
        assert main(["status", "mine.yaml"]) == 0
    Path("results").write_text("in the way")
    assert main(["points", "mine.yaml"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("warning: mine.yaml: study: got 'results/mine'; allowed: a folder")


@pytest.mark.parametrize(
    ("point", "word"),
    [
        ("{system: belt, width: 1.0e+13}", "allocate"),
        ("{system: chute, depth: 1.0e-15, cell: 1.0e+10}", "dimension"),
    ],
)
def test_what_no_machine_can_compute_ends_in_one_line(point, word, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("point.yaml").write_text(point)
    assert main(["run", "point.yaml", "-o", "run.nc", "--quiet"]) == 1
    *_, line = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and "cannot be computed" in line and word in line
    assert not Path("run.nc").exists()


@pytest.mark.parametrize("output", ["file/run.nc", "folder"])
def test_outputs_that_cannot_be_written(output, tmp_path, refuse):
    (tmp_path / "point.yaml").write_text("system: belt\n")
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "folder").mkdir()
    assert "--output: got " in refuse("run", "point.yaml", "-o", output)


def test_a_reader_that_leaves_early_is_no_error():
    command = f"{sys.executable} -m sim points config/paper.yaml | head -n 1"
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command], cwd=ROOT, capture_output=True, text=True
    )
    assert done.stdout.startswith("id ")
    assert done.stderr == ""


LINES = {
    "refine": ["refine", "x.yaml", "1"],
    "run": ["run", "x.yaml", "-o", "run.nc"],
    "adopt": ["adopt", "x.yaml", "x.nc"],
    "info": ["info", "run.nc"],
    "export": ["export", "run.nc", "--to", "vtk"],
    "compare": ["compare", "a.nc", "b.nc"],
    "figure": ["figure", "walton_2", "x.nc", "-o", "folder"],
    "publish": ["publish", "x.yaml", "--to", "folder"],
} | {name: [name] for name in ("status", "schema", "warm", "clean", "verify")}


@pytest.mark.parametrize("words", [["points", "config/quick.yaml"], ["--print-completion", "bash"]])
def test_an_output_that_is_full_is_one_line(words):
    with Path("/dev/full").open("w") as full:
        done = program(*words, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert "No space left on device" in done.stderr


@pytest.mark.parametrize("name", [*COMMANDS, *EARLIER_NAMES])
def test_every_command_has_a_function_that_takes_its_options(name):
    options = parse(LINES.get(name, [name, "x.yaml"]))
    signature(resolve_name(options.pop("function"))).bind(**options)


def test_the_program_alone_says_how_to_start():
    done = program()
    assert done.returncode == 2
    assert "python -m sim init my-study.yaml" in done.stderr and "-h" in done.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["points"], "Missing argument 'STUDY.yaml|RUN.nc'. python -m sim points -h tells more"),
        (["run", "x.yaml"], "Missing option '-o' / '--output'. "),
        (["stduy", "x.yaml"], "No such command 'stduy'. Did you mean 'study'? python -m sim -h "),
        (["--versoin"], "No such option '--versoin'. Did you mean '--version'? "),
        (["study", "x.yaml", "--dryrun"], "No such option '--dryrun'. Did you mean '--dry-run'? "),
        (["points", "x.yaml", "y.yaml"], "Got unexpected extra argument (y.yaml) "),
        (["job"], "Missing command. python -m sim job -h tells more"),
        (["export", "x.nc", "--to", "vkt"], "Invalid value for '--to': 'vkt' is not one of "),
    ],
)
def test_a_command_line_that_is_wrong_is_one_line(words, message, capsys):
    assert refusal(capsys, *words).startswith(f"error: {message}")


def test_twelve_commands_are_listed_and_those_of_the_workflow_apart(capsys):
    for words, listed in (([], COMMANDS), (["job"], JOBS)):
        with pytest.raises(SystemExit) as ended:
            main([*words, "-h"])
        (text,) = re.findall(r"Commands:\n((?:  .*\n)+)", capsys.readouterr().out)
        assert ended.value.code == 0 and re.findall(r"^  (\S+)", text, re.M) == list(listed)
    assert len(COMMANDS) == 12


def test_a_dry_run_is_handed_to_snakemake():
    for words in (["-n"], ["--dry-run"]):
        options = parse(["study", "x.yaml", *words, "--", "-q", "--keep-going"])
        assert options["dry_run"] and options["extra"] == ("-q", "--keep-going")
    assert parse(["study", "x.yaml"])["extra"] == ()


def test_compiled_code_is_removed_and_nothing_else(tmp_path):
    (tmp_path / "0123456789ab" / "deep").mkdir(parents=True)
    (tmp_path / "0123456789ab" / "deep" / "code.nbc").write_bytes(bytes(1_600_000))
    for name in ("mine", "202611251234", "202611251234-202611251234"):
        (tmp_path / name).mkdir()
    (tmp_path / "202611251234" / "photo.jpg").touch()
    (tmp_path / "202611251234" / "code.nbi").touch()
    (tmp_path / "ba9876543210").symlink_to(tmp_path / "mine")
    for place, words in ((tmp_path, f"{tmp_path}: 2 MB of compiled code removed\n"), ("no", "")):
        folder = os.environ | {"TALUS_CACHE_DIR": str(tmp_path / place)}
        done = program("job", "warm", "--clean", env=folder)
        assert done.returncode == 0 and done.stdout.startswith(words)
    left = {"202611251234", "202611251234-202611251234", "ba9876543210", "mine"}
    assert {path.name for path in tmp_path.iterdir()} == left
