"""A run that is interrupted from the keyboard says so and leaves nothing half-written."""

import signal
import subprocess
import sys
import time
from pathlib import Path

from sim.parameters import parse_point
from sim.warm import warm

ROOT = Path(__file__).parents[1]


def test_interrupt_ends_a_run_cleanly(tmp_path):
    warm([parse_point({"system": "belt"}, "test")])
    process = subprocess.Popen(
        [sys.executable, "-m", "sim", "run", "-", "-o", str(tmp_path / "run.nc")],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    # The first log line says that the run has started, so it tells when to interrupt.
    process.stdin.write("{system: belt, frequency: 20, average: 1.0e+5}")
    process.stdin.close()

    assert "200 particles" in process.stderr.readline()
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    code = process.wait(timeout=60)
    errors = process.stderr.read()
    assert code == 130, errors
    assert errors.splitlines()[-1] == "interrupted"
    assert list(tmp_path.iterdir()) == []
