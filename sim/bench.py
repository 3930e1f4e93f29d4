"""``python -m sim bench``: speed on one core, start-up and memory of the engine on this machine."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from sim.parameters import Parameters, canonical_json, parse_point

#: Depth, stiffness (N/m) and start velocity (√(gσ)) of the chute flows, all in a 10×10 cell.
CHUTES = [(5, 117), (10, 117), (40, 117), (5, 1170), (10, 1170), (40, 1170)]
START_VELOCITY = {5: 8.0, 10: 16.0, 40: 25.0}

#: Time (√(σ/g)) that the spheres are given to fall and begin to shear before the clock starts.
RELAXATION = 16.0

#: Timed stretches per flow, of which the median counts, and particle-steps in each.
REPEATS = 5
STRETCH = 4e6

_FIRST_STEP = """
import json, sys, time
from sim.parameters import parse_point
from sim.systems import build
system = build(parse_point(json.loads(sys.argv[1]), "bench"), 0)
system.advance()
print(time.time())
"""

# VmHWM belongs to the interpreter alone; getrusage would count what its parent had before the fork.
_PEAK_MEMORY = """
import json, re, sys
from pathlib import Path
from sim.parameters import parse_point
from sim.run import run_point
run_point(parse_point(json.loads(sys.argv[1]), "bench"), Path(sys.argv[2]), quiet=True)
print(int(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1]) / 1024)
"""


def main() -> None:
    """Print the table of rates, then start-up times and peak memory."""
    print("flow                          particles  contacts/particle  million particle-steps/s")
    for depth, stiffness in CHUTES:
        values = {"depth": depth, "stiffness": stiffness, "cell": 10}
        values["initial_velocity"] = START_VELOCITY[depth]
        _report_rate(f"chute depth {depth}, K1 = {stiffness} N/m", _point("chute", values))
    _report_rate("belt, 50 Hz", _point("belt", {"frequency": 50, "transient": 10}))
    for system in ("chute", "belt"):
        point = _point(system, {})
        print(f"{system}: {_first_step(point):.2f} s from process start to first samples, warm")
        with tempfile.TemporaryDirectory() as cache:
            seconds = _first_step(point, TALUS_CACHE_DIR=cache)
        print(f"{system}: {seconds:.1f} s from process start to first samples, cold cache")
        print(f"{system}: {_peak_memory(point):.0f} MB peak memory of a run process")


def _point(system: str, values: dict) -> Parameters:
    return parse_point({"system": system, **values}, "bench")


def _report_rate(name: str, point: Parameters) -> None:
    """Measure and print the speed of one flow, after it has relaxed."""
    from sim.systems import build

    system = build(point, 0)
    system.settle()
    if point.system == "chute":
        interval = point.sample_steps * point.time_step / point.time_unit
        relaxation = int(RELAXATION / interval)
    else:
        relaxation = point.transient_samples
    for _ in range(relaxation):
        system.advance()
    samples = max(1, int(STRETCH / (point.sample_steps * point.particles)))
    rates, contacts = [], []
    for _ in range(REPEATS):
        started = time.perf_counter()
        contacts += [system.advance()["contact_number"] for _ in range(samples)]
        elapsed = time.perf_counter() - started
        rates.append(samples * point.sample_steps * point.particles / elapsed / 1e6)
    rate, contact = statistics.median(rates), statistics.mean(contacts)
    print(f"{name:30}{point.particles:9}{contact:19.2f}{rate:26.1f}", flush=True)


def _first_step(point: Parameters, **environment: str) -> float:
    """Return the seconds from the start of a process to the end of its first sample interval."""
    started = time.time()
    return float(_in_child(_FIRST_STEP, canonical_json(point), **environment)) - started


def _peak_memory(point: Parameters) -> float:
    """Return the largest resident memory (MB) of a process that runs this point for a while."""
    short = point.model_copy(update={"transient": 1.0, "average": 4.0})
    with tempfile.TemporaryDirectory() as folder:
        return float(_in_child(_PEAK_MEMORY, canonical_json(short), f"{folder}/run.nc"))


def _in_child(code: str, *arguments: str, **environment: str) -> str:
    """Run a few lines in a fresh interpreter and return what they print."""
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=os.environ | environment,
        cwd=Path(__file__).parent.parent,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
