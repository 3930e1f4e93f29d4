"""What a run says of its progress: lines, bar and file, by a clock of the tests."""

import json
import logging
import os
import sys

import pytest

from sim.engine.progress import progress, progress_file, read_progress
from sim.parameters import point_id
from tests.engine_motion.points import belt_point, chute_point

POINT = chute_point(depth=2, cell=5, transient=100, average=400)
STEPS = POINT.steps


class Clock:
    """A clock that stands still until it is told."""

    time = 5000.0

    def __call__(self) -> float:
        return self.time


@pytest.fixture
def clock(monkeypatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr("sim.engine.progress.monotonic", clock)
    return clock


@pytest.fixture
def output(tmp_path):
    return tmp_path / "run.nc"


@pytest.fixture
def log(caplog):
    """What is logged, in ``log.messages``."""
    caplog.set_level(logging.INFO, logger="talus")
    return caplog


def test_log_lines_become_rarer(clock, output, log):
    seconds = []
    with progress(POINT, output) as advance:
        for second in range(5, 1000, 5):
            clock.time += 5.0
            advance(1)
            seconds += [second] * (len(log.messages) - len(seconds))
    assert seconds == [10, 30, 70, 150, 310, 610, 910]


@pytest.mark.parametrize(("limit", "bound"), [(None, ""), (800, "at most ")])
def test_a_line_says_how_far_how_fast_and_how_long_still(limit, bound, clock, output, log):
    """A run in its first sample may be compiling, which tells nothing of what is to come."""
    values = {"protocol": "converged", "limit": limit} if limit else {}
    point = chute_point(depth=2, cell=5, transient=100, average=400, **values)
    with progress(point, output) as advance:
        clock.time += 100.0
        advance(0)
        assert log.messages == [f"{point_id(point)}: 0 % of {bound}{point.steps:,} steps"]
        assert read_progress(output).remaining_seconds is None
        clock.time += 100.0
        advance(point.steps // 4)
        now = read_progress(output)
    rate = point.steps // 4 * point.particles / 100.0
    assert now.rate == pytest.approx(rate) and now.elapsed == 200.0
    assert log.messages[1] == (
        f"{point_id(point)}: 25 % of {bound}{point.steps:,} steps, "
        f"{rate / 1e6:.1f} million particle-steps/s, {bound or 'about '}5.0 min left"
    )


def test_a_bar_and_no_lines_show_on_a_terminal_and_nothing_when_quiet(
    clock, output, log, capsys, monkeypatch
):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    for quiet in (False, True):
        with progress(POINT, output, quiet=quiet, done=STEPS // 2) as advance:
            clock.time += 1000.0
            advance(STEPS // 2)
        assert ("100%" in capsys.readouterr().err) is not quiet
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False)
    with progress(POINT, output, quiet=True) as advance:
        clock.time += 1000.0
        advance(5)
    assert log.messages == []


def test_the_file_tells_the_run_until_it_ends(clock, output):
    point = belt_point(replicates=3)
    with progress(point, output) as advance:
        start = read_progress(output)
        assert (start.done, start.rate, start.remaining_seconds, start.remaining_time) == (
            0,
            0,
            None,
            "unknown",
        )
        advance(0)
        clock.time += 50.0
        advance(point.steps)
        now = read_progress(output)
    assert (now.point, now.pid, now.particles) == (point_id(point), os.getpid(), point.particles)
    assert (now.done, now.total, now.percent) == (point.steps, 3 * point.steps, 33)
    assert now.rate == pytest.approx(point.steps * point.particles / 50.0)
    assert (now.elapsed, now.remaining_seconds) == pytest.approx((50.0, 100.0))
    assert list(output.parent.iterdir()) == []


def test_the_file_is_not_written_all_the_time_and_needs_not_be_writable(clock, output, tmp_path):
    written = set()
    with progress(POINT, output) as advance, progress(POINT, tmp_path / "none" / "run.nc") as other:
        for _ in range(100):
            clock.time += 0.1
            advance(1)
            other(1)
            written.add(read_progress(output).done)
    assert len(written) in (5, 6)


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError, SystemExit])
def test_the_file_goes_with_a_run_that_raises_but_not_with_one_that_is_terminated(output, error):
    with pytest.raises(error), progress(POINT, output):
        assert progress_file(output).exists()
        raise error
    assert progress_file(output).exists() == (error is SystemExit)


def test_a_run_that_resumes_counts_what_lies_behind_it(clock, output):
    with progress(POINT, output, done=STEPS // 2) as advance:
        advance(0)
        assert read_progress(output).percent == 50
        clock.time += 10.0
        advance(STEPS // 4)
        now = read_progress(output)
    assert now.percent == 75
    assert now.rate == pytest.approx(STEPS // 4 * POINT.particles / 10.0)
    assert now.remaining_seconds == pytest.approx(10.0, rel=1e-3)


def test_files_that_say_nothing_are_nothing(clock, output):
    with progress(POINT, output):
        text = progress_file(output).read_text()
        broken = [b"", b"\xff\x00", text[: len(text) // 2].encode(), b"[1]", b"null", b"{}"]
        for change in ({"rate": "fast"}, {"done": -1}, {"total": 0}):
            broken.append(json.dumps(json.loads(text) | change).encode())
        for content in broken:
            progress_file(output).write_bytes(content)
            assert read_progress(output) is None, content
    assert read_progress(output) is None
