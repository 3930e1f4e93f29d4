"""A run that was stopped at any moment goes on from its states to the same bits."""

import errno
import io
import json
import logging
import os
import signal
import subprocess
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.engine import states
from sim.engine.command import warm
from sim.engine.replicate import Replicate, stored_replicate
from sim.engine.run import run_point
from sim.engine.states import SHARE, States, checkpoint_interval, pack, unpack
from sim.engine.systems import start
from sim.parameters import Parameters, canonical_values
from tests.engine_motion.points import belt_point, chute_point, pause_within_samples
from tests.golden import contents, digest
from tests.made.processes import ROOT, program

POINTS = {
    "chute": chute_point(depth=2, cell=5, transient=5, average=10, replicates=2),
    "chute of two threads": chute_point(depth=2, cell=5, transient=5, average=10, threads=2),
    "belt": belt_point(beads=20, width=5, transient=1, average=6, replicates=2),
    "belt shaken before": belt_point(
        beads=20, width=5, prior_frequency=30, prior_cycles=3, transient=1, average=2
    ),
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
    """Return a replacement of ``States.offer`` that saves and then stops the run."""
    count = 0

    def offer(self, replicate) -> None:
        nonlocal count
        count += 1
        if count == offers:
            self.keep(replicate)
            self.save()
            raise Stopped

    return offer


@pytest.mark.parametrize("name", POINTS)
@pytest.mark.parametrize("share", [0.01, pytest.param(0.4, marks=pytest.mark.long), 0.99])
def test_a_run_continued_from_a_checkpoint_gives_the_same_bits(name, share, tmp_path, monkeypatch):
    point = POINTS[name]
    assert run_point(point, tmp_path / "whole.nc", quiet=True) == 0
    offers = 3 * point.replicates * point.steps // point.sample_steps
    output = tmp_path / "run.nc"
    for _ in range(2):
        with monkeypatch.context() as patched, pytest.raises(Stopped):
            patched.setattr(States, "offer", stop_after(max(1, int(share * offers / 2))))
            pause_within_samples(patched, point)
            run_point(point, output, quiet=True)
        assert not output.exists()
    assert run_point(point, output, quiet=True) == 0
    assert_same(output, tmp_path / "whole.nc")
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {"run.nc", ".run.nc.state", "whole.nc", ".whole.nc.state"}


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


def start_computing(output: Path, point: Path) -> subprocess.Popen:
    """Start a run of LONG and return it once it is well beyond its first checkpoint."""
    warm([LONG])
    point.write_text(json.dumps(canonical_values(LONG)))
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
    return process


@pytest.fixture
def point_file(tmp_path_factory) -> Path:
    """Where the parameters of a run may be written."""
    return tmp_path_factory.mktemp("point") / "point.json"


def test_a_killed_run_goes_on_where_it_was(tmp_path, point_file):
    output = tmp_path / "run.nc"
    first = start_computing(output, point_file)
    first.send_signal(signal.SIGKILL)
    first.communicate()
    assert not output.exists()
    second = program("run", str(point_file), "--output", str(output))
    assert second.returncode == 0, second.stderr
    assert "continued from a checkpoint" in second.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", ".run.nc.state"}
    run_point(LONG, tmp_path / "whole.nc", quiet=True)
    assert_same(output, tmp_path / "whole.nc")


class SamplingKeeper:
    """Keeps every tenth of the states that are offered before the first sample."""

    def __init__(self):
        self.states: list[dict] = []
        self.offered = 0

    def offer(self, replicate: Replicate) -> None:
        self.offered += 1
        if replicate.system.stage and self.offered % 10 == 0:
            self.states.append(unpack(pack(replicate.state())))

    def check_signals(self) -> None:
        pass

    def keep(self, replicate: Replicate) -> None:
        pass


def test_a_bed_that_has_not_settled_yet_goes_on_where_it_was(monkeypatch):
    point = POINTS["belt shaken before"]
    pause_within_samples(monkeypatch, point)
    start.beds.clear()
    keeper = SamplingKeeper()
    whole = Replicate(point, 0).run(lambda steps: None, keeper)
    assert {state["told.stage"] for state in keeper.states} == {"falling", "shaken before"}
    for state in keeper.states[:: len(keeper.states) // 6]:
        again = Replicate.from_state(point, 0, state).run(lambda steps: None, SamplingKeeper())
        assert np.array_equal(again.snapshots["position"], whole.snapshots["position"])
        assert np.array_equal(again.series["mean_velocity"], whole.series["mean_velocity"])


def test_before_there_is_a_state_a_run_ends_at_once(tmp_path):
    with pytest.raises(SystemExit) as ended, States(tmp_path / "run.nc", POINTS["belt"]):
        signal.raise_signal(signal.SIGTERM)
    assert ended.value.code == states.TERMINATION_CODE
    assert not list(tmp_path.iterdir())


def test_after_the_end_a_run_ends_with_what_was_kept(tmp_path):
    kept, replicate = States(tmp_path / "run.nc", POINTS["belt"]), start_replicate(POINTS["belt"])
    with pytest.raises(SystemExit), kept:
        kept.offer(replicate)
        kept.keep(replicate)
        signal.raise_signal(signal.SIGTERM)
        replicate.system.advance()
        kept.check_signals()
    assert read(tmp_path).recorder.sample_count == 1


def start_replicate(parameters: Parameters) -> Replicate:
    """Return a replicate after its first samples."""
    replicate = Replicate(parameters, 0)
    replicate.system.settle()
    replicate.recorder.take_snapshot()
    replicate.recorder.take(replicate.system.sample())
    return replicate


@pytest.fixture
def saved(tmp_path) -> States:
    """The states of a run of the belt, of which the first replicate has begun."""
    made = States(tmp_path / "run.nc", POINTS["belt"])
    made.keep(start_replicate(POINTS["belt"]))
    made.save()
    return made


def read(tmp_path: Path, point: Parameters = POINTS["belt"]) -> Replicate | None:
    """Return the first replicate of a run as its file of states has it."""
    return stored_replicate(States(tmp_path / "run.nc", point), point, 0)


def assert_set_aside(
    tmp_path: Path, caplog, words: str, point: Parameters = POINTS["belt"]
) -> None:
    """Assert that states are not accepted and kept for inspection, with one warning."""
    path = tmp_path / ".run.nc.state"
    with caplog.at_level(logging.WARNING):
        assert read(tmp_path, point) is None
    (warning,) = caplog.messages
    assert words in warning and "set aside" in warning
    assert not path.exists()
    assert path.with_name(".run.nc.state.damaged").exists()
    assert read(tmp_path, point) is None


def test_what_was_saved_is_read(saved, tmp_path):
    one, other = read(tmp_path), read(tmp_path)
    assert one.recorder.sample_count == 1
    assert one.recorder.system is one.system
    assert one.system.advance() == other.system.advance()


def test_nothing_is_read_where_nothing_was_saved(tmp_path, caplog):
    assert read(tmp_path) is None
    assert not caplog.messages


@pytest.mark.parametrize("share", [0.0, 0.001, 0.5, 0.99, 1.0])
def test_a_truncated_file_is_set_aside(saved, share, tmp_path, caplog):
    whole = saved.path.read_bytes()
    saved.path.write_bytes(whole[: int(share * (len(whole) - 1))])
    assert_set_aside(tmp_path, caplog, "damaged")


@pytest.mark.parametrize("place", [0.0, 0.3, 0.6, 1.0])
def test_a_flipped_bit_is_found(saved, place, tmp_path, caplog):
    whole = bytearray(saved.path.read_bytes())
    state = whole.index(b"\n") + 1
    whole[state + int(place * (len(whole) - 1 - state))] ^= 4
    saved.path.write_bytes(whole)
    assert_set_aside(tmp_path, caplog, "the checksum is wrong")


def test_a_flipped_bit_of_the_first_line_is_found(saved, tmp_path, caplog):
    whole = saved.path.read_bytes()
    saved.path.write_bytes(whole.replace(b"belt-frequency", b"belt-frequencx", 1))
    assert_set_aside(tmp_path, caplog, "other point")


def test_states_that_the_system_does_not_give_stay_as_they_are(saved, tmp_path, monkeypatch):
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fail(*_: object, **__: object) -> int:
        raise OSError(errno.EIO, "input/output error")

    monkeypatch.setattr("sim.base.files.os.open", fail)
    with pytest.raises(OSError, match="input/output error"):
        read(tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_longer_file_is_set_aside(saved, tmp_path, caplog):
    saved.path.write_bytes(saved.path.read_bytes() + b"more")
    assert_set_aside(tmp_path, caplog, "checksum")


@pytest.mark.parametrize(
    ("name", "words"), [("FORMAT", "other format"), ("NUMERICS", "other numerics")]
)
def test_states_of_other_code_are_set_aside(tmp_path, name, words, caplog, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(states, name, 0)
        made = States(tmp_path / "run.nc", POINTS["belt"])
        made.keep(start_replicate(POINTS["belt"]))
        made.save()
    assert_set_aside(tmp_path, caplog, words)


def test_states_of_another_point_are_set_aside(saved, tmp_path, caplog):
    other = POINTS["belt"].model_copy(update={"seed": 2})
    assert_set_aside(tmp_path, caplog, "other point", other)


def with_changes(state: dict, changes: dict) -> dict:
    """Return a state with other values at some places, without those that are none."""
    return {name: one for name, one in (state | changes).items() if one is not None}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"moving.disks.label": None}, "disks.label"),
        ({"moving.more": 1.0}, "more"),
        ({"moving.disks.taylor": np.zeros((2, 2))}, "disks.taylor"),
        ({"moving.disks.taylor": np.zeros((6, 3, 20))}, "disks.taylor has the lengths (6, 3, 20)"),
        ({"moving.loop.step": np.zeros(1, np.float32)}, "loop.step"),
        ({"moving.belt_work": "much"}, "belt_work"),
        ({"table": np.zeros((3, 1))}, "series"),
        ({"profiles.length": None}, "length"),
        ({"taken": None}, "taken"),
    ],
)
def test_a_state_of_another_shape_is_none_of_the_replicate(saved, changes, words, tmp_path, caplog):
    """Sealed, of this run, and yet written by a program that keeps other things."""
    state = start_replicate(POINTS["belt"]).state()
    saved._archives[0] = pack(with_changes(state, changes))
    saved.save()
    with caplog.at_level(logging.WARNING):
        assert read(tmp_path) is None
    (warning,) = caplog.messages
    assert "replicate 0 starts anew" in warning and words in warning


@pytest.mark.parametrize("archive", [b"", b"no archive", pack({})[:-5]])
def test_what_is_no_state_is_told_and_left_alone(saved, archive, tmp_path, caplog):
    saved._archives[0] = archive
    saved.save()
    assert read(tmp_path) is None
    assert "starts anew" in caplog.text


def test_nothing_that_lies_in_a_file_is_run(saved, tmp_path, caplog):
    """An array of objects is a pickle, which could run anything."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("numbers.json", "{}")
        with archive.open("trap", "w") as member:
            np.lib.format.write_array(member, np.array([Trap()], object), allow_pickle=True)
    with pytest.raises(ValueError, match="allow_pickle"):
        unpack(buffer.getvalue())
    assert not Trap.sprung


class Trap:
    """Tells when it is unpickled."""

    sprung = False

    def __reduce__(self):
        return setattr, (Trap, "sprung", True)


def test_states_are_written_when_they_are_due_and_not_before(tmp_path):
    replicate = start_replicate(POINTS["belt"])
    now = States(tmp_path / "now.nc", POINTS["belt"], 0.0)
    now.offer(replicate)
    assert now.path.exists()
    later = States(tmp_path / "later.nc", POINTS["belt"], 60.0)
    later.offer(replicate)
    assert not later.path.exists()


def test_writing_takes_no_more_than_its_share_of_the_time(tmp_path, monkeypatch):
    now, saves = 0.0, []

    def slow(self) -> None:
        nonlocal now
        saves.append(now)
        now += 0.05

    monkeypatch.setattr("sim.engine.states.time", SimpleNamespace(monotonic=lambda: now))
    monkeypatch.setattr(States, "save", slow)
    kept = States(tmp_path / "run.nc", POINTS["belt"], 0.0)
    replicate = start_replicate(POINTS["belt"])
    while now < 5.0:
        kept.offer(replicate)
        now += 0.01
    assert 4 <= len(saves) <= 5
    assert np.diff(saves).min() >= 0.05 / SHARE


def test_states_that_cannot_be_written_stop_no_run(tmp_path, caplog):
    kept = States(tmp_path / "missing" / "run.nc", POINTS["belt"], 0.0)
    with caplog.at_level(logging.WARNING):
        kept.offer(start_replicate(POINTS["belt"]))
    (warning,) = caplog.messages
    assert "no states are kept: No such file" in warning


def test_leftovers_of_killed_writes_are_removed_with_the_next(saved):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    left = saved.path.with_name(f".{saved.path.name}.{dead.pid}.part")
    left.write_text("half")
    saved.save()
    assert not left.exists() and saved.path.exists()


@pytest.mark.parametrize("text", ["soon", "-1", "nan"])
def test_the_interval_is_a_number_of_seconds(text, monkeypatch):
    monkeypatch.setenv("TALUS_CHECKPOINT_SECONDS", text)
    with pytest.raises(InputError, match=r"TALUS_CHECKPOINT_SECONDS: got .*; allowed: a number"):
        checkpoint_interval()


def test_wall_time_counts_on_in_another_process(monkeypatch):
    now = 5.0
    monkeypatch.setattr("sim.engine.replicate.time", SimpleNamespace(monotonic=lambda: now))
    replicate = start_replicate(POINTS["belt"])
    now = 7.0
    state = replicate.state()
    now = 1000.0
    replicate = Replicate.from_state(POINTS["belt"], 0, state)
    now = 1003.0
    assert replicate.seconds == pytest.approx(5.0)


def test_a_run_that_is_asked_to_end_saves_first(tmp_path, point_file):
    process = start_computing(tmp_path / "run.nc", point_file)
    process.send_signal(signal.SIGTERM)
    errors = process.communicate()[1]
    assert process.returncode == 143, errors
    assert errors.splitlines()[-1].endswith("terminated; the next start continues from here")
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {".run.nc.state", ".run.nc.progress"}
    assert read(tmp_path, LONG).recorder.sample_count > 0
