"""An interrupted run keeps its state; before there is any, it just ends."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sim.engine.command import save_and_end
from sim.engine.progress import progress_file
from sim.engine.warm import warm
from sim.parameters import parse_point

ROOT = Path(__file__).parents[2]


@pytest.fixture
def process(tmp_path):
    """A long run that has started."""
    warm([parse_point({"system": "belt"}, "test")])
    process = subprocess.Popen(
        [sys.executable, "-m", "sim", "run", "-", "-o", str(tmp_path / "run.nc")],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdin.write("{system: belt, frequency: 20, average: 1.0e+5}")
    process.stdin.close()
    deadline = time.monotonic() + 60
    while not progress_file(tmp_path / "run.nc").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    yield process
    process.kill()
    process.wait()


def test_an_interrupt_saves_the_state_of_a_run(process, tmp_path):
    process.send_signal(signal.SIGINT)
    code = process.wait(timeout=60)
    last = process.stderr.read().splitlines()[-1]
    assert (code, last.partition(": ")[2]) == (
        143,
        "terminated; the next start continues from here",
    )
    assert not (tmp_path / "run.nc").exists()
    assert (tmp_path / ".run.nc.checkpoint").stat().st_size > 0
    # `status` takes it for interrupted by this file.
    assert progress_file(tmp_path / "run.nc").exists()


@pytest.fixture
def signals():
    """What the two signals do, put back afterwards."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_without_anything_to_save_an_interrupt_ends_at_once(signals):
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with pytest.raises(KeyboardInterrupt):
        save_and_end(signal.SIGINT, None)


def test_the_second_interrupt_ends_at_once(signals):
    told = []
    signal.signal(signal.SIGTERM, lambda *_: told.append("save"))
    signal.signal(signal.SIGINT, save_and_end)
    signal.raise_signal(signal.SIGINT)
    assert told == ["save"]
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    assert told == ["save"]
