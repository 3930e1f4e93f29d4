"""Whatever a study file holds, it is a study or an error of one line, also on the command line."""

import io
import os
import re
import resource
import socket
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.__main__ import main
from sim.base.errors import InputError
from sim.base.yaml import MAX_BYTES, parse_yaml
from sim.claims.claim import claims
from sim.study.command import init
from sim.study.figure_spec import FIGURES
from sim.study.load import Study, load_study, parse_study
from tests.made.processes import ROOT, program, refusal, restore_plugins
from tests.properties.values import SCALARS, TOKENS, mutated_texts, mutated_trees

STUDIES = [
    ROOT / "config" / "quick.yaml",
    *(ROOT / "tests" / "data" / name for name in ("tiny.yaml", "spread.yaml")),
]
TEXTS = [path.read_text() for path in STUDIES]
TREES = [yaml.safe_load(text) for text in TEXTS]


def outcome(work, *arguments) -> Study | str:
    """What ``work`` returns, or the line with which it refuses its input."""
    try:
        return work(*arguments)
    except InputError as error:
        message = str(error)
        assert message.startswith("study.yaml: ") and message.isprintable()
        assert len(message) < 1500
        return message


def study_of(text: str) -> Study | str:
    def work():
        return parse_study(parse_yaml(text, "study.yaml"), "study.yaml", ROOT / "none")

    return outcome(work)


@given(mutated_trees(TREES))
def test_mutated_studies(tree):
    outcome(parse_study, tree, "study.yaml", ROOT / "none")


@given(mutated_texts(TEXTS))
def test_mutated_texts(text):
    study_of(text)


@given(
    st.one_of(mutated_texts(TEXTS).map(str.encode), st.binary(max_size=200)), st.binary(max_size=3)
)
def test_any_bytes_on_the_command_line(data, end):
    """Exit code 0 and a table, or 2 and one line on standard error."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_bytes(data + end)
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            code = main(["points", str(path)])
    if code == 0:
        assert err.getvalue() == "" and out.getvalue().startswith("id ")
    else:
        assert code == 2 and out.getvalue() == ""
        assert re.fullmatch(r"error: .*study\.yaml: .+\n", err.getvalue())


def limit_memory() -> None:
    """Let a process have 2 GB at most."""
    resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31))


def test_what_has_no_end_is_refused_unread(tmp_path, monkeypatch, capsys):
    """Devices, pipes and sockets that nobody writes to, huge files and inputs."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    huge = tmp_path / "study.yaml"
    with huge.open("wb") as file:
        file.write(b"study: mine\n#")
        file.truncate(10**9)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        for name in ("/dev/zero", "/dev/null", "pipe", "socket"):
            assert f"{name}: a device or pipe" in refusal(capsys, "points", name)
    assert refusal(capsys, "points", huge).endswith("study.yaml: larger than 1 MB")
    with Path("/dev/zero").open("rb") as endless:
        done = program("points", "-", stdin=endless, preexec_fn=limit_memory)
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch("error: <stdin>: larger than 1 MB\n", done.stderr)
    head = b"study: mine\nseries: [{name: a, system: chute}]\n#"
    huge.write_bytes(head + b"x" * (MAX_BYTES - len(head)))
    assert list(load_study(huge, tmp_path).series) == ["a"]


@pytest.mark.parametrize("name", ["a\0b", "x" * 5000, "no/such/file", "\udcff", "a\nb", "{x}"])
@pytest.mark.parametrize("command", [["points"], ["run", "--output", "run.nc"]])
def test_names_that_no_file_has(name, command, capsys):
    refusal(capsys, *command, name)


LONG = "x" * 300


@pytest.mark.parametrize(
    "words",
    [
        ["compare", LONG, LONG],
        ["export", f"{LONG}.nc", "-o", "beads.xyz", "--to", "extxyz"],
    ],
)
def test_a_name_that_no_file_system_takes_is_bad_input(words, capsys):
    assert "File name too long" in refusal(capsys, *words)


def bomb(first: str, opening: str, closing: str) -> str:
    """Anchors each of which stands for nine times the one before, forty times over."""
    lines = [f"a0: &a0 {first}"]
    for n in range(40):
        lines.append(f"a{n + 1}: &a{n + 1} {opening}[{', '.join([f'*a{n}'] * 9)}]{closing}")
    return "\n".join(lines)


#: Texts that are small and stand for much, or for what no study holds; a piece of the message.
HOSTILE = {
    "aliases that multiply": (bomb("[x]", "", ""), "unknown key"),
    "merge keys that multiply": (bomb("{x: 1}", "{<<: ", "}"), "more than 1,000,000 keys"),
    "deep": ("[" * 100_000, "nested"),
    "endless number": (f"study: {'1' * 5000}", "YAML"),
    "recursive list": ("study: &a [*a]", "study: got [["),
    "recursive mapping": ("&a\nstudy: mine\nseries: [*a]", "series[0]"),
    "recursive merge": ("&a\nstudy: mine\n<<: *a", "series: got nothing"),
    "recursive key": ("? &a [*a]\n: 1", "expected text as a key"),
    "number as key": ("study: mine\n1: 2", "line 2, column 1: not readable as YAML: expected text"),
    "nothing as key": ("? \n: 1", "expected text as a key"),
    "list tagged as text as key": ("? !!str [a]\n: 1", "expected text as a key"),
    "set": ("study: !!set {a}", "tag"),
    "binary": ("study: !!binary aGk=", "tag"),
    "timestamp": ("study: !!timestamp x", "tag"),
    "object": ("study: !!python/object/apply:os.getpid []", "tag"),
    "long tag": (f"study: !{'a' * 10_000} x", "tag"),
    "tag with an escape sequence": ("study: !a%1B b x", "tag"),
    "base 60": (f"study: !!int {'1:' * 10_000}1", "whole number"),
    "base 60, with a point": (f"study: !!float {'1:' * 10_000}1", "decimal number"),
    "long number in base 16": (f"study: !!int 0x{'f' * 10_000}", "whole number"),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_hostile_texts(kind):
    text, piece = HOSTILE[kind]
    assert piece in study_of(text)


# Whatever the files beside a study hold, it is a study or an error of one line that names a file.
#
# They are those of a stranger's paper, and measurements.


PAPER = {path.name: path.read_text() for path in (ROOT / "config/paper/mine").glob("*.yaml")}

#: A study that is calibrated by measurements, and the measurements.
CALIBRATED = """\
study: beads
series:
  - name: wide
    system: chute
    design: {kind: sobol, points: 8, over: {friction: [0.3, 0.8], angle: [14, 18]}}
surrogate: [{name: speed, series: wide}]
calibrate:
  - {name: beads, data: exp.csv, surrogate: speed, parameters: {friction: [0.3, 0.8]}}
"""
MEASURED = """\
# from a laboratory
angle (deg), velocity (mm/s), velocity_error (mm/s), note
14.5, 212, 8, "first, dry"
16.0, 254, 8,
"""

#: What may stand in a YAML file.
PLAIN = SCALARS.filter(lambda one: one is None or isinstance(one, (bool, int, float, str)))
NODES = st.recursive(
    PLAIN, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(PLAIN, inner))
)

#: Each loads a study: fewer with each change.
FEW = settings(max_examples=settings().max_examples // 4)


def load(folder: Path, study: str) -> None:
    """Load a study and what papers say, or be refused in one line that names a file."""
    with restore_plugins():
        try:
            load_study(folder / study, None)
            list(FIGURES)
            claims(["chute"])
        except InputError as error:
            message = str(error)
            assert message.isprintable() and len(message) < 1500
            assert re.search(r"\.(yaml|csv|py): ", message), message


def load_paper(name: str, content: bytes) -> None:
    with TemporaryDirectory() as folder:
        init(Path(folder), "", "mine")
        (Path(folder) / "mine" / name).write_bytes(content)
        load(Path(folder), "mine.yaml")


@FEW
@given(st.data())
def test_mutated_files_of_a_paper(data):
    text = PAPER[name := data.draw(st.sampled_from(sorted(PAPER)))]
    if data.draw(st.booleans()):
        text = data.draw(mutated_texts([text]))
    else:
        tree = data.draw(mutated_trees([yaml.safe_load(text)], NODES, PLAIN))
        text = yaml.safe_dump(tree, allow_unicode=True)
    load_paper(name, text.encode(errors="surrogatepass"))


@FEW
@given(
    st.one_of(
        mutated_texts([MEASURED]).map(str.encode),
        st.lists(st.one_of(TOKENS, st.text(max_size=3))).map(" ".join).map(str.encode),
        st.binary(max_size=50),
    )
)
def test_measurements_of_all_kinds(content):
    with TemporaryDirectory() as folder:
        (Path(folder) / "beads.yaml").write_text(CALIBRATED)
        (Path(folder) / "exp.csv").write_bytes(content)
        load(Path(folder), "beads.yaml")
