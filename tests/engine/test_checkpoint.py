"""A run that was stopped at any moment goes on from its checkpoint to the same bits."""

import json
import logging
import os
import pickle
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.base.files import seal
from sim.engine import checkpoint
from sim.engine.checkpoint import SHARE, Checkpoint, checkpoint_interval
from sim.engine.replicate import Replicate, Stopwatch
from sim.engine.run import run_point
from sim.engine.warm import warm
from sim.parameters import Parameters, canonical
from tests.engine_motion.points import belt_point, chute_point
from tests.golden import contents, digest
from tests.made.processes import ROOT, program

POINTS = {
    "chute": chute_point(depth=2, cell=5, transient=5, average=10, replicates=2),
    "chute of two threads": chute_point(depth=2, cell=5, transient=5, average=10, threads=2),
    "belt": belt_point(beads=20, width=5, transient=1, average=6, replicates=2),
}
LONG = belt_point(beads=60, width=8, transient=10, average=20, replicates=2)


def assert_same(one: Path, other: Path) -> None:
    """Assert that two run files hold the same bits."""
    first, second = contents(one), contents(other)
    differ = [name for name in first if not np.array_equal(first[name], second.get(name))]
    assert digest(one) == digest(other), differ


class Stopped(BaseException):
    """Ends a run as a kill would: nothing is tidied up but locks."""


def stop_after(offers: int):
    """Return a replacement of ``Checkpoint.offer`` that saves and then stops the run."""
    count = 0

    def offer(self, state) -> None:
        nonlocal count
        count += 1
        if count == offers:
            self.save(state)
            raise Stopped

    return offer


@pytest.mark.parametrize("name", POINTS)
@pytest.mark.parametrize("share", [0.01, 0.4, 0.99])
def test_a_run_continued_from_a_checkpoint_gives_the_same_bits(name, share, tmp_path, monkeypatch):
    point = POINTS[name]
    assert run_point(point, tmp_path / "whole.nc", quiet=True) == 0
    samples = point.replicates * point.steps // point.sample_steps
    output = tmp_path / "run.nc"
    for _ in range(2):
        with monkeypatch.context() as patched, pytest.raises(Stopped):
            patched.setattr(Checkpoint, "offer", stop_after(max(1, int(share * samples / 2))))
            run_point(point, output, quiet=True)
        assert not output.exists()
    assert run_point(point, output, quiet=True) == 0
    assert_same(output, tmp_path / "whole.nc")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.nc", "whole.nc"]


#: The program, but it waits for its standard input to end some samples after a checkpoint.
HELD = """
import itertools, runpy, sys
from sim.engine.checkpoint import Checkpoint

offer, later = Checkpoint.offer, itertools.count()

def offer_and_wait(self, state):
    offer(self, state)
    if self.path.exists() and next(later) == 10:
        print("computing", flush=True)
        sys.stdin.read()

Checkpoint.offer = offer_and_wait
runpy.run_module("sim", run_name="__main__")
"""


def computing(output: Path, point: Path) -> subprocess.Popen:
    """Start a run of LONG and return it once it is well beyond its first checkpoint."""
    warm([LONG])
    point.write_text(json.dumps(canonical(LONG)))
    process = subprocess.Popen(
        [sys.executable, "-c", HELD, "run", str(point), "--output", str(output)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.01"},
    )
    assert process.stdout.readline() == "computing\n", process.stderr.read()
    return process


@pytest.fixture
def point_file(tmp_path_factory) -> Path:
    """Where the parameters of a run may be written."""
    return tmp_path_factory.mktemp("point") / "point.json"


def test_a_killed_run_goes_on_where_it_was(tmp_path, point_file):
    output = tmp_path / "run.nc"
    first = computing(output, point_file)
    first.send_signal(signal.SIGKILL)
    first.communicate()
    assert not output.exists()
    second = program("run", str(point_file), "--output", str(output))
    assert second.returncode == 0, second.stderr
    assert "continued from a checkpoint" in second.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    run_point(LONG, tmp_path / "whole.nc", quiet=True)
    assert_same(output, tmp_path / "whole.nc")


def started(parameters: Parameters) -> Replicate:
    """Return a replicate after its first samples."""
    replicate = Replicate(parameters, 0)
    replicate.system.settle()
    replicate.recorder.take_snapshot()
    replicate.recorder.take(replicate.system.advance())
    return replicate


@pytest.fixture
def saved(tmp_path) -> Checkpoint:
    """A checkpoint of a run of the belt."""
    made = Checkpoint(tmp_path / "run.nc", POINTS["belt"])
    made.save(started(POINTS["belt"]))
    return made


def assert_set_aside(refused: Checkpoint, caplog, words: str) -> None:
    """Assert that a checkpoint is not accepted and kept for inspection, with one warning."""
    with caplog.at_level(logging.WARNING):
        assert refused.load() is None
    (warning,) = caplog.messages
    assert words in warning and "the run starts anew" in warning
    assert not refused.path.exists()
    assert refused.path.with_name(".run.nc.checkpoint.damaged").exists()
    assert refused.load() is None


def test_what_was_saved_is_loaded(saved):
    loaded = saved.load()
    assert loaded.recorder.taken == 1
    assert loaded.recorder.system is loaded.system
    assert loaded.system.advance() == saved.load().system.advance()


def test_nothing_is_loaded_where_nothing_was_saved(tmp_path, caplog):
    assert Checkpoint(tmp_path / "run.nc", POINTS["belt"]).load() is None
    assert not caplog.messages


@pytest.mark.parametrize("share", [0.0, 0.001, 0.5, 0.99, 1.0])
def test_a_truncated_checkpoint_is_set_aside(saved, share, caplog):
    whole = saved.path.read_bytes()
    saved.path.write_bytes(whole[: int(share * (len(whole) - 1))])
    assert_set_aside(saved, caplog, "damaged")


@pytest.mark.parametrize("place", [0.0, 0.3, 0.6, 1.0])
def test_a_flipped_bit_is_found(saved, place, caplog):
    whole = bytearray(saved.path.read_bytes())
    state = whole.index(b"\n") + 1
    whole[state + int(place * (len(whole) - 1 - state))] ^= 4
    saved.path.write_bytes(whole)
    assert_set_aside(saved, caplog, "the checksum is wrong")


def test_a_flipped_bit_of_the_first_line_is_found(saved, caplog):
    saved.path.write_bytes(saved.path.read_bytes().replace(b'"beads": 20,', b'"beads": 21,', 1))
    assert_set_aside(saved, caplog, "other parameters")


def test_the_state_of_a_checkpoint_is_all_that_lies_behind_its_first_line(saved, caplog):
    """Sealed, of this run, and yet no state: written by something else."""
    first, _, _ = saved.path.read_bytes().partition(b"\n")
    saved.path.write_bytes(first + b"\nno pickle")
    seal(saved.path)
    assert_set_aside(saved, caplog, "cannot be unpacked")


def test_a_longer_checkpoint_is_set_aside(saved, caplog):
    saved.path.write_bytes(saved.path.read_bytes() + b"more")
    assert_set_aside(saved, caplog, "checksum")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("source_hash", lambda: "0" * 12, "other source hash"),
        ("__version__", "0.0.1", "other talus"),
        ("FORMAT", 0, "other format"),
        ("library_versions", lambda: {"numpy": "1.0"}, "other libraries"),
    ],
)
def test_a_checkpoint_of_other_code_is_set_aside(tmp_path, name, value, words, caplog, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(checkpoint, name, value)
        Checkpoint(tmp_path / "run.nc", POINTS["belt"]).save(started(POINTS["belt"]))
    assert_set_aside(Checkpoint(tmp_path / "run.nc", POINTS["belt"]), caplog, words)


def test_a_checkpoint_of_another_point_is_set_aside(saved, tmp_path, caplog):
    other = POINTS["belt"].model_copy(update={"seed": 2})
    assert_set_aside(Checkpoint(tmp_path / "run.nc", other), caplog, "other parameters")


class Trap:
    """Tells when it is unpickled."""

    sprung = False

    def __reduce__(self):
        return setattr, (Trap, "sprung", True)


def test_nothing_is_unpickled_before_the_checksum_holds(saved, caplog):
    saved.save(Trap())
    whole = bytearray(saved.path.read_bytes())
    whole[-1] ^= 1
    saved.path.write_bytes(whole)
    assert_set_aside(saved, caplog, "checksum")
    assert not Trap.sprung


def test_a_checkpoint_is_written_when_it_is_due_and_not_before(tmp_path):
    now = Checkpoint(tmp_path / "now.nc", POINTS["belt"], 0.0)
    now.offer("state")
    assert now.load() == "state"
    later = Checkpoint(tmp_path / "later.nc", POINTS["belt"], 60.0)
    later.offer("state")
    assert not later.path.exists()


def test_writing_takes_no_more_than_its_share_of_the_time(tmp_path, monkeypatch):
    now, saves = 0.0, []

    def slow(self, state) -> None:
        nonlocal now
        saves.append(now)
        now += 0.05

    monkeypatch.setattr("sim.engine.checkpoint.time", SimpleNamespace(monotonic=lambda: now))
    monkeypatch.setattr(Checkpoint, "save", slow)
    kept = Checkpoint(tmp_path / "run.nc", POINTS["belt"], 0.0)
    while now < 5.0:
        kept.offer("state")
        now += 0.01
    assert 4 <= len(saves) <= 5
    assert np.diff(saves).min() >= 0.05 / SHARE


def test_a_checkpoint_that_cannot_be_written_stops_no_run(tmp_path, caplog):
    kept = Checkpoint(tmp_path / "missing" / "run.nc", POINTS["belt"], 0.0)
    with caplog.at_level(logging.WARNING):
        kept.offer("state")
    (warning,) = caplog.messages
    assert "no checkpoint: No such file" in warning


def test_leftovers_of_killed_writes_are_removed_with_the_checkpoint(saved):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    left = saved.path.with_name(f".{saved.path.name}.{dead.pid}.part")
    left.write_text("half")
    saved.remove()
    assert not left.exists() and not saved.path.exists()


@pytest.mark.parametrize("text", ["soon", "-1", "nan"])
def test_the_interval_is_a_number_of_seconds(text, monkeypatch):
    monkeypatch.setenv("TALUS_CHECKPOINT_SECONDS", text)
    with pytest.raises(InputError, match=r"TALUS_CHECKPOINT_SECONDS: got .*; allowed: a number"):
        checkpoint_interval()


def test_a_stopwatch_counts_on_in_another_life(monkeypatch):
    now = 5.0
    monkeypatch.setattr("sim.engine.replicate.time", SimpleNamespace(monotonic=lambda: now))
    watch = Stopwatch(100.0)
    now = 7.0
    saved = pickle.dumps(watch)
    now = 1000.0
    watch = pickle.loads(saved)
    now = 1003.0
    assert watch.seconds() == pytest.approx(105.0)


def test_a_run_that_is_asked_to_end_saves_first(tmp_path, point_file):
    process = computing(tmp_path / "run.nc", point_file)
    process.send_signal(signal.SIGTERM)
    errors = process.communicate()[1]
    assert process.returncode == 143, errors
    assert errors.splitlines()[-1].endswith("terminated; the next start continues from here")
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {".run.nc.checkpoint", ".run.nc.progress"}
    assert Checkpoint(tmp_path / "run.nc", LONG).load().replicate.number == 0
