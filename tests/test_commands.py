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

# What is replaced in STUDY, by what; the key and two pieces of the message.
MISTAKES = {
    "unknown key at the top": ("study: mine", "study: mine\ntitel: x", "titel", "mean title?"),
    "parameter at the top": (
        "study: mine",
        "study: mine\nreplicates: 3",
        "replicates",
        "defaults.",
    ),
    "unknown key of a series": ("grid:", "gird:", "series[0].gird", "mean grid?"),
    "unknown parameter": (
        "friction: [",
        "fricton: [",
        "series[0].grid.fricton",
        "did you mean friction",
    ),
    "unknown parameter in a case": (
        "frequency",
        "freqency",
        "series[1].cases[0].freqency",
        "mean frequency? ",
    ),
    "parameter of the other system": (
        "{frequency: 20}",
        "{depth: 5}",
        "series[1].cases[0].depth",
        "unknown key",
    ),
    "unknown system": ("system: belt", "system: blet", "series[1].system", "'blet'", "mean belt?"),
    "no system": ("    system: belt\n", "", "series[1].system", "chute, belt"),
    "no name": ("name: second\n    ", "", "series[1].name", "got nothing"),
    "no study": ("study: mine\n", "", "study", "got nothing"),
    "name that leaves the folder": (
        "study: mine",
        "study: ../mine",
        "study",
        "'../mine'",
        "letters",
    ),
    "two series of one name": ("name: second", "name: first", "series[1].name", "'first'"),
    "word for a number": ("0.7,", "high,", "series[0].grid.restitution[0]", "'high'", "[0.001, 1]"),
    "point in an integer": (
        "{frequency: 20}",
        "{beads: 10.0}",
        "series[1].cases[0].beads",
        "got 10.0;",
        "an integer in [1, 10000000]",
    ),
    "name of another folder": ("study: mine", "study: published", "study", "'published'"),
    "number in quotes": ("0.7,", "'0.7',", "series[0].grid.restitution[0]", "'0.7'", "[0.001, 1]"),
    "true for a number": ("0.7,", "true,", "series[0].grid.restitution[0]", "got true"),
    "nothing for a number": ("0.7,", "null,", "series[0].grid.restitution[0]", "got nothing"),
    "not a number": ("0.7,", ".nan,", "series[0].grid.restitution[0]", "nan", "finite"),
    "infinite": ("[1, 2]", "[1, .inf]", "series[0].grid.depth[1]", "inf", "finite"),
    "restitution 0": ("0.85", "0", "series[0].grid.restitution[1]", "got 0;", "[0.001, 1]"),
    "one value for a list": ("[1, 2]", "1", "series[0].grid.depth", "a list of at least one"),
    "empty list": ("[1, 2]", "[]", "series[0].grid.depth", "got []", "at least one"),
    "empty grid": (
        re.compile(r"grid:\n(      .*\n)+"),
        "grid: {}\n",
        "series[0].grid",
        "at least one parameter",
    ),
    "grid of nothing": (
        re.compile(r"grid:\n(      .*\n)+"),
        "grid:\n",
        "series[0].grid",
        "got nothing",
    ),
    "no cases": ("[{frequency: 20}]", "[]", "series[1].cases", "at least one"),
    "no series": (re.compile(r"series:\n(.*\n)+"), "series: []\n", "series", "at least one"),
    "series of words": (re.compile(r"series:\n(.*\n)+"), "series: [a]\n", "series[0]", "a mapping"),
    "unknown figure": ("walton_2", "walton_3", "series[0].figures[0]", "'walton_3'", "walton_2"),
    "figure of the other system": (
        "walton_2",
        "gallas_1a",
        "series[0].figures[0]",
        "'gallas_1a'",
        "a figure of the chute",
    ),
    "figure without a series": (
        "study: mine",
        "study: mine\nfigures: [walton_2, gallas_1c]",
        "figures[1]",
        "'gallas_1c'",
        "a series of the study feeds",
    ),
    "rule between parameters": (
        "{frequency: 20}",
        "{width: 10, obstacle: 7.5}",
        "series[1].cases[0].obstacle",
        "got 7.5;",
        "[0, 7)",
    ),
    "override of a gridded parameter": (
        "figures:",
        "overrides: [{when: {depth: [2]}, set: {depth: 3}}]\n    figures:",
        "series[0].overrides[0].set.depth",
        "other than grid.depth",
    ),
    "override that breaks a range": (
        "figures:",
        "overrides: [{when: {depth: [2]}, set: {cell: 1}}]\n    figures:",
        "series[0].overrides[0].set.cell",
        "got 1;",
        ">= 3",
    ),
    "override without values": (
        "figures:",
        "overrides: [{when: {depth: [2]}}]\n    figures:",
        "series[0].overrides[0].set",
        "got nothing",
    ),
    "bad default": (
        "study: mine",
        "study: mine\ndefaults: {belt: {damping: -1}}",
        "defaults.belt.damping",
        "got -1;",
        ">= 0",
    ),
    "duplicate key": ("study: mine", "study: mine\nstudy: yours", "study", "line 2", "line 1"),
    "duplicate parameter": (
        "      depth: [1, 2]",
        "      depth: [1, 2]\n      depth: [3]",
        "series[0].grid.depth",
        "line 8",
        "line 7",
    ),
}

# The whole text of a file, and pieces of the message.
UNREADABLE = {
    "open bracket": ("study: mine\nseries: [\n", "line 3", "YAML"),
    "tab": ("study: mine\n\tseries: []\n", "line 2", "YAML"),
    "two documents": ("study: mine\n---\nstudy: yours\n", "line 2", "another document"),
    "tag that does not fit": ("study: !!bool maybe\n", "YAML"),
    "list": ("- study: mine\n", "a mapping"),
    "word": ("study\n", "a mapping"),
    "empty": ("", "empty"),
    "comments": ("# nothing\n", "empty"),
    "endless number": (f"study: {'1' * 5000}\n", "YAML"),
    "deep": ("[" * 100_000, "nested"),
    "key of two lines": ('"a\\nb": 1\n', r"'a\nb': unknown key"),
    "long key": (f"{'a' * 500}: 1\n", "aaa...aaa", "unknown key"),
    "tag of two lines": ("study: !a%0Ab x\n", "line 1", "YAML"),
}


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


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_in_a_study(mistake, tmp_path, refuse):
    old, new, key, *pieces = MISTAKES[mistake]
    pattern = old if isinstance(old, re.Pattern) else re.compile(re.escape(old))
    text, count = pattern.subn(lambda _: new, STUDY, count=1)
    assert count == 1
    (tmp_path / "mine.yaml").write_text(text)
    message = refuse("points", "mine.yaml")
    assert message.startswith(f"error: mine.yaml: {key}: ")
    for piece in pieces:
        assert piece in message
    assert len(message) < 700


def test_the_study_without_mistakes_is_accepted(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(STUDY)
    assert main(["points", "mine.yaml"]) == 0
    assert "13 points" in capsys.readouterr().out


@pytest.mark.parametrize("kind", UNREADABLE)
def test_files_that_are_not_yaml(kind, tmp_path, refuse):
    text, *pieces = UNREADABLE[kind]
    (tmp_path / "mine.yaml").write_text(text)
    message = refuse("points", "mine.yaml")
    assert "mine.yaml: " in message
    for piece in pieces:
        assert piece in message


@pytest.mark.parametrize("data", [b"\x89HDF\r\n\x1a\n\xff\xfe", b"study: a\x00b\n"])
@pytest.mark.parametrize("command", [["points", "mine.yaml"], ["run", "mine.yaml", "-o", "run.nc"]])
def test_binary_files(data, command, tmp_path, refuse):
    (tmp_path / "mine.yaml").write_bytes(data)
    assert "mine.yaml: not a text file" in refuse(*command)


@pytest.mark.parametrize("command", [["points"], ["run", "-o", "run.nc"]])
def test_files_that_are_not_there(command, tmp_path, refuse):
    assert "none.yaml: no such file" in refuse(*command, "none.yaml")
    (tmp_path / "folder").mkdir()
    assert "folder: a folder" in refuse(*command, "folder")


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


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        ("system: chute\nrestitution: 1.5\n", ["restitution: got 1.5", "[0.001, 1]"]),
        ("system: chute\nrestituton: 0.5\n", ["restituton: unknown key", "mean restitution?"]),
        ("depth: 5\n", ["system: got nothing", "chute, belt"]),
        ("system: chute\nsystem: belt\n", ["system: duplicate key on line 2"]),
        ("[1]\n", ["a mapping"]),
        (STUDY, ["a study, not a point; python -m sim study point.yaml runs it"]),
    ],
)
def test_mistakes_in_a_point(text, pieces, tmp_path, refuse):
    (tmp_path / "point.yaml").write_text(text)
    message = refuse("run", "point.yaml", "-o", "run.nc")
    assert message.startswith("error: point.yaml: ")
    for piece in pieces:
        assert piece in message


def test_a_process_ends_without_a_traceback(tmp_path):
    output = tmp_path / "run.nc"
    done = program("run", "-", "-o", str(output), input="system: chute\nfriction: -1\n")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == "error: <stdin>: friction: got -1; allowed: a number >= 0\n"
    assert not output.exists()


def test_a_reader_that_leaves_early_is_no_error(tmp_path):
    command = f"{sys.executable} -m sim points config/paper.yaml --results {tmp_path} | head -n 1"
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
} | {name: [name] for name in ("status", "schema", "warm", "clean")}


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
    folder = os.environ | {"TALUS_CACHE_DIR": str(tmp_path)}
    done = program("job", "warm", "--clean", env=folder)
    assert done.stdout == f"{tmp_path}: 2 MB of compiled code removed\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "202611251234",
        "202611251234-202611251234",
        "ba9876543210",
        "mine",
    ]
    assert (
        program(
            "job", "warm", "--clean", env=os.environ | {"TALUS_CACHE_DIR": str(tmp_path / "no")}
        ).returncode
        == 0
    )


def test_a_terminal_that_knows_few_letters_is_shown_the_others_by_their_numbers():
    plain = {"PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "LC_ALL": "C"}
    done = program("schema", env=os.environ | plain)
    assert done.returncode == 0, done.stderr
    assert "\\u27e8d\\u27e9" in done.stdout
