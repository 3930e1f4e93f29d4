"""A run that is interrupted from the keyboard says so and leaves nothing half-written."""

import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_interrupt_ends_a_run_cleanly(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "sim", "run", "-", "-o", str(tmp_path / "run.nc")],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    # The warning about the time step is logged when the run starts, so it tells when to interrupt.
    process.stdin.write("{system: belt, frequency: 10, average: 1.0e+5}")
    process.stdin.close()
    assert "time step" in process.stderr.readline()
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 130
    assert process.stderr.read().splitlines()[-1] == "interrupted"
    assert list(tmp_path.iterdir()) == []
