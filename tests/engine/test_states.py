"""A run that was stopped at any moment goes on from its states to the same bits.

`tests/golden` interrupts runs within and between samples; here are kills, and files that are odd.
"""

import errno
import json
import logging
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.engine import states
from sim.engine.command import warm
from sim.engine.replicate import Replicate, stored_replicate
from sim.engine.run import run_point
from sim.engine.states import SHARE, States, checkpoint_interval, pack
from sim.parameters import Parameters, canonical_values
from tests.engine_motion.points import belt_point
from tests.golden import contents, digest
from tests.made.processes import ROOT, program

BELT = belt_point(beads=20, width=5, transient=1, average=6, replicates=2)
LONG = belt_point(beads=60, width=8, transient=10, average=20, replicates=2)


def assert_same(one: Path, other: Path) -> None:
    """Assert that two run files hold the same bits."""
    first, second = contents(one), contents(other)
    differ = [name for name in first if not np.array_equal(first[name], second.get(name))]
    assert digest(one) == digest(other), differ


#: The program, but it waits for its standard input to end some samples after a checkpoint.
WAITING_PROGRAM = """
import itertools, runpy, sys
from sim.engine.states import States

offer, later = States.offer, itertools.count()

def offer_and_wait(self, replicate):
    offer(self, replicate)
    if self.path.exists() and next(later) == 10:
        print("computing", flush=True)
        sys.stdin.read()

States.offer = offer_and_wait
runpy.run_module("sim", run_name="__main__")
"""


@pytest.fixture
def computing(tmp_path, tmp_path_factory):
    """A run of LONG well beyond its first checkpoint, and the file of its point."""
    warm([LONG])
    point = tmp_path_factory.mktemp("point") / "point.json"
    point.write_text(json.dumps(canonical_values(LONG)))
    output = tmp_path / "run.nc"
    process = subprocess.Popen(
        [sys.executable, "-c", WAITING_PROGRAM, "run", str(point), "--output", str(output)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.01"},
    )
    assert process.stdout.readline() == "computing\n", process.stderr.read()
    return process, point


def names(folder: Path) -> set[str]:
    """Return the names of all files of a folder."""
    return {path.name for path in folder.iterdir()}


def test_a_killed_run_goes_on_where_it_was(tmp_path, computing):
    first, point = computing
    output = tmp_path / "run.nc"
    first.send_signal(signal.SIGKILL)
    first.communicate()
    assert not output.exists()
    second = program("run", str(point), "--output", str(output))
    assert second.returncode == 0, second.stderr
    assert "continued from a checkpoint" in second.stderr
    assert names(tmp_path) == {"run.nc", ".run.nc.state"}
    run_point(LONG, tmp_path / "whole.nc", quiet=True)
    assert_same(output, tmp_path / "whole.nc")


def test_a_run_that_is_asked_to_end_saves_first(tmp_path, computing):
    process, _ = computing
    process.send_signal(signal.SIGTERM)
    errors = process.communicate()[1]
    assert process.returncode == 143, errors
    assert errors.splitlines()[-1].endswith("terminated; the next start continues from here")
    assert names(tmp_path) == {".run.nc.state", ".run.nc.progress"}
    assert read(tmp_path, LONG).recorder.sample_count > 0


def test_before_there_is_a_state_a_run_ends_at_once(tmp_path):
    with pytest.raises(SystemExit) as ended, States(tmp_path / "run.nc", BELT):
        signal.raise_signal(signal.SIGTERM)
    assert ended.value.code == states.TERMINATION_CODE
    assert not list(tmp_path.iterdir())


def test_after_the_end_a_run_ends_with_what_was_kept(tmp_path):
    kept, replicate = States(tmp_path / "run.nc", BELT), start_replicate()
    with pytest.raises(SystemExit), kept:
        kept.offer(replicate)
        kept.keep(replicate)
        signal.raise_signal(signal.SIGTERM)
        replicate.system.advance()
        kept.check_signals()
    assert read(tmp_path).recorder.sample_count == 1


def start_replicate() -> Replicate:
    """Return a replicate after its first samples."""
    replicate = Replicate(BELT, 0)
    replicate.system.settle()
    replicate.recorder.take_snapshot()
    replicate.recorder.take(replicate.system.sample())
    return replicate


@pytest.fixture
def saved(tmp_path) -> States:
    """The states of a run of the belt, of which the first replicate has begun."""
    made = States(tmp_path / "run.nc", BELT)
    made.keep(start_replicate())
    made.save()
    return made


def read(tmp_path: Path, point: Parameters = BELT) -> Replicate | None:
    """Return the first replicate of a run as its file of states has it."""
    return stored_replicate(States(tmp_path / "run.nc", point), point, 0)


def test_what_was_saved_is_read_and_nothing_else_is(saved, tmp_path, caplog):
    one, other = read(tmp_path), read(tmp_path)
    assert one.recorder.sample_count == 1
    assert one.recorder.system is one.system
    assert one.system.advance() == other.system.advance()
    assert read(tmp_path / "elsewhere") is None and not caplog.messages


def flipped(content: bytes, place: float) -> bytes:
    """Return bytes with a flipped bit behind the first line."""
    changed, state = bytearray(content), content.index(b"\n") + 1
    changed[state + int(place * (len(content) - 1 - state))] ^= 4
    return bytes(changed)


#: Files that are damaged or of another run.
UNUSABLE = {
    "empty": lambda whole: b"",
    "cut in the first line": lambda whole: whole[:20],
    "cut": lambda whole: whole[: len(whole) // 2],
    "cut by a byte": lambda whole: whole[:-1],
    "longer": lambda whole: whole + b"more",
    "flipped": lambda whole: flipped(whole, 0.3),
    "flipped in the seal": lambda whole: flipped(whole, 1.0),
    "another first line": lambda whole: whole.replace(b"belt-frequency", b"belt-frequencx", 1),
}


@pytest.mark.parametrize("kind", [*UNUSABLE, "FORMAT", "NUMERICS", "point"])
def test_states_that_cannot_be_used_are_set_aside(kind, tmp_path, caplog, monkeypatch, request):
    """They are kept for inspection, with one warning."""
    point, words = BELT, "the checksum is wrong"
    with monkeypatch.context() as patched:
        if kind not in UNUSABLE:
            words = f"other {kind.lower()}"
        if kind.isupper():
            patched.setattr(states, kind, 0)
        path = request.getfixturevalue("saved").path
    if kind in UNUSABLE:
        path.write_bytes(UNUSABLE[kind](path.read_bytes()))
    elif kind == "point":
        point = BELT.model_copy(update={"seed": 2})
    with caplog.at_level(logging.WARNING):
        assert read(tmp_path, point) is None
    (warning,) = caplog.messages
    assert words in warning and "set aside" in warning
    assert names(tmp_path) == {".run.nc.state.damaged"}
    assert read(tmp_path, point) is None


def test_states_that_the_system_does_not_give_stay_as_they_are(saved, tmp_path, monkeypatch):
    before = saved.path.read_bytes()

    def fail(*_: object, **__: object) -> int:
        raise OSError(errno.EIO, "input/output error")

    with monkeypatch.context() as patched, pytest.raises(OSError, match="input/output error"):
        patched.setattr("sim.base.files.os.open", fail)
        read(tmp_path)
    assert names(tmp_path) == {saved.path.name} and saved.path.read_bytes() == before


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"moving.disks.label": None}, "disks.label"),
        ({"moving.more": 1.0}, "more"),
        ({"moving.disks.taylor": np.zeros((2, 2))}, "disks.taylor"),
        ({"moving.disks.taylor": np.zeros((6, 3, 20))}, "disks.taylor is not as"),
        ({"moving.loop.step": np.zeros(1, np.float32)}, "loop.step"),
        ({"moving.belt_work": "much"}, "belt_work"),
        ({"table": np.zeros((3, 1))}, "series"),
        ({"profiles.length": None}, "length"),
        ({"taken": None}, "taken"),
    ],
)
def test_a_state_of_another_shape_is_none_of_the_replicate(saved, changes, words, tmp_path, caplog):
    """Sealed, of this run, and yet written by a program that keeps other things."""
    changed = start_replicate().state() | changes
    saved._archives[0] = pack({name: one for name, one in changed.items() if one is not None})
    saved.save()
    with caplog.at_level(logging.WARNING):
        assert read(tmp_path) is None
    (warning,) = caplog.messages
    assert "replicate 0 starts anew" in warning and words in warning


def test_states_are_written_when_due_for_a_share_of_the_time(tmp_path, monkeypatch):
    now, saves = 0.0, []

    def slow(self) -> None:
        nonlocal now
        saves.append(now)
        now += 0.05

    monkeypatch.setattr("sim.engine.states.time", SimpleNamespace(monotonic=lambda: now))
    monkeypatch.setattr(States, "save", slow)
    replicate = start_replicate()
    States(tmp_path / "later.nc", BELT, 60.0).offer(replicate)
    assert not saves
    kept = States(tmp_path / "run.nc", BELT, 0.0)
    while now < 5.0:
        kept.offer(replicate)
        now += 0.01
    assert 4 <= len(saves) <= 5
    assert np.diff(saves).min() >= 0.05 / SHARE


@pytest.mark.parametrize("text", ["soon", "-1", "nan"])
def test_the_interval_is_a_number_of_seconds(text, monkeypatch):
    monkeypatch.setenv("TALUS_CHECKPOINT_SECONDS", text)
    with pytest.raises(InputError, match=r"TALUS_CHECKPOINT_SECONDS: got .*; allowed: a number"):
        checkpoint_interval()


def test_wall_time_counts_on_in_another_process(monkeypatch):
    now = 5.0
    monkeypatch.setattr("sim.engine.replicate.time", SimpleNamespace(monotonic=lambda: now))
    replicate = start_replicate()
    now = 7.0
    state = replicate.state()
    now = 1000.0
    replicate = Replicate.from_state(BELT, 0, state)
    now = 1003.0
    assert replicate.seconds == pytest.approx(5.0)
