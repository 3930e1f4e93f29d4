"""An interrupted run keeps its state; before there is any, it just ends."""

import os
import signal

import pytest

from sim.engine.command import save_and_end, warm
from sim.engine.progress import progress_file
from tests.engine_motion.points import belt_point
from tests.made.processes import start_run, wait_until

#: Runs that last: one of a long average, one whose bed never comes to rest, one that is shaken
#: before for long.
LONG_RUNS = {
    "flow": belt_point(frequency=20, average=1e5),
    "fall": belt_point(beads=400, settle_velocity_squared=1e-15),
    "prior shaking": belt_point(prior_frequency=20, prior_cycles=10**5),
}


@pytest.fixture(params=LONG_RUNS)
def process(request, tmp_path):
    """A long run that has kept a state."""
    point = LONG_RUNS[request.param]
    warm([LONG_RUNS["flow"]])
    often = os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.01"}
    process = start_run(point, tmp_path / "run.nc", env=often)
    wait_until((tmp_path / ".run.nc.state").exists, process)
    yield process
    process.kill()
    process.wait()


def test_an_interrupt_saves_the_state_of_a_run(process, tmp_path):
    process.send_signal(signal.SIGINT)
    code = process.wait()
    last = process.stderr.read().splitlines()[-1]
    assert (code, last.partition(": ")[2]) == (
        143,
        "terminated; the next start continues from here",
    )
    assert not (tmp_path / "run.nc").exists()
    assert (tmp_path / ".run.nc.state").stat().st_size > 0
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
    calls = []
    signal.signal(signal.SIGTERM, lambda *_: calls.append("save"))
    signal.signal(signal.SIGINT, save_and_end)
    signal.raise_signal(signal.SIGINT)
    assert calls == ["save"]
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    assert calls == ["save"]
