"""``python -m benchmarks.engine``: speed, threads, start-up, memory of the engine."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, cast

from sim.engine.systems import build
from sim.engine.systems.chute import Chute
from sim.engine.systems.replica import Replica
from sim.parameters import SYSTEMS, ChuteParameters, Parameters, canonical_json, parse_point

#: Depth and side of the cell (both in diameters) of the chute flows, and their stiffnesses (N/m).
SIZES = [(5, 10), (10, 10), (40, 10), (20, 40)]
STIFFNESSES = [117, 1170]

#: Start velocity (√(gσ)) by depth, near that of the developed flow.
START_VELOCITY = {5: 8.0, 10: 16.0, 20: 25.0, 40: 25.0}

#: Time (√(σ/g)) in which the spheres fall and begin to shear before the clock starts.
RELAXATION = 16.0
SHORT_RELAXATION = 6.0

#: Timed stretches per flow, whose median is reported, and particle-steps in each.
REPEATS = 5
STRETCH = 4e6

_FIRST_SAMPLE = """
import json, sys, time
from sim.parameters import parse_point
from sim.engine.systems import build
system = build(parse_point(json.loads(sys.argv[1]), "bench"), 0)
system.advance()
print(time.time())
"""

# VmHWM counts the interpreter alone; getrusage would include its parent's memory before the fork.
_PEAK_MEMORY = """
import json, re, sys
from pathlib import Path
from sim.parameters import parse_point
from sim.engine.run import run_point
run_point(parse_point(json.loads(sys.argv[1]), "bench"), Path(sys.argv[2]), quiet=True)
print(int(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1]) / 1024)
"""


def main() -> None:
    """Print the tables of rates, then start-up times and peak memory."""
    print("flow                          particles  contacts/particle  million particle-steps/s")
    for stiffness in STIFFNESSES:
        for depth, cell in SIZES:
            _report_rate(
                f"chute depth {depth}, K1 = {stiffness} N/m", _chute(depth, cell, stiffness)
            )
    _report_rate("belt, 50 Hz", _point("belt", {"frequency": 50, "transient": 10}))
    print("flow, depth 10, K1 = 117 N/m, by size")
    for cell in (10, 32, 100):
        _report_rate(f"chute, cell {cell}", _chute(10, cell, 117, SHORT_RELAXATION))
    for stiffness in STIFFNESSES:
        for depth, cell in SIZES[2:]:
            _report_threads(_chute(depth, cell, stiffness))
    for system in SYSTEMS:
        point = _point(system, {})
        print(f"{system}: {_time_setup(point) * 1e3:.1f} ms to set up a further run")
        print(
            f"{system}: {_time_first_sample(point):.2f} s from process start to first samples, warm"
        )
        with tempfile.TemporaryDirectory() as cache:
            seconds = _time_first_sample(point, TALUS_CACHE_DIR=cache)
        print(f"{system}: {seconds:.1f} s from process start to first samples, cold cache")
        print(f"{system}: {_measure_peak_memory(point):.0f} MB peak memory of a run process")


def _chute(
    depth: int, cell: int, stiffness: float, relaxation: float = RELAXATION
) -> ChuteParameters:
    values = {"depth": depth, "cell": cell, "stiffness": stiffness, "transient": relaxation}
    point = _point("chute", values | {"initial_velocity": START_VELOCITY[depth]})
    return cast(ChuteParameters, point)


def _point(system: str, values: dict[str, Any]) -> Parameters:
    return parse_point({"system": system, **values}, "bench")


def _build_relaxed(point: Parameters) -> Replica:
    """Return the point's flow after its transient."""
    system = build(point, 0)
    system.settle()
    for _ in range(point.transient_samples):
        system.advance()
    return system


def _time_stretch(system: Replica) -> tuple[float, float]:
    """Return million particle-steps/s and contacts per particle over one stretch."""
    point = system.parameters
    samples = max(1, int(STRETCH / (point.sample_steps * point.particles)))
    started = time.perf_counter()
    contacts = [system.advance()["contact_number"] for _ in range(samples)]
    elapsed = time.perf_counter() - started
    rate = samples * point.sample_steps * point.particles / elapsed / 1e6
    return rate, statistics.mean(contacts)


def _report_rate(name: str, point: Parameters) -> None:
    """Measure and print the speed of one flow, after it has relaxed."""
    system = _build_relaxed(point)
    rates, contacts = zip(*(_time_stretch(system) for _ in range(REPEATS)), strict=True)
    rate, contact = statistics.median(rates), statistics.mean(contacts)
    print(f"{name:30}{point.particles:9}{contact:19.2f}{rate:26.1f}", flush=True)


def _copy_with_threads(system: Chute, threads: int) -> Chute:
    """Return a flow in the same state on ``threads`` threads, without memory of its contacts."""
    copy = Chute(system.parameters.model_copy(update={"threads": threads}), 0)
    for name in ("position", "velocity", "rim", "label"):
        getattr(copy.spheres, name)[:] = getattr(system.spheres, name)
    copy.spheres.orientation[:] = system.spheres.orientation
    copy.advance()
    return copy


def _report_threads(point: ChuteParameters) -> None:
    """Measure and print the speed-up by two threads.

    Stretches on one and on two threads alternate, each from the same state.
    """
    system, ratios = cast(Chute, _build_relaxed(point)), []
    for _ in range(REPEATS):
        rates = [_time_stretch(_copy_with_threads(system, threads))[0] for threads in (1, 2)]
        ratios.append(rates[1] / rates[0])
    ratio = statistics.median(ratios)
    print(f"depth {point.depth:g}, {point.particles} particles: two threads {ratio:.2f} x one")


def _time_setup(point: Parameters) -> float:
    """Return the seconds to set up a run in a process that has set up another before."""
    seconds = []
    for seed in range(1, 2 * REPEATS):
        started = time.perf_counter()
        build(point.model_copy(update={"seed": seed}), 0)
        seconds.append(time.perf_counter() - started)
    return statistics.median(seconds)


def _time_first_sample(point: Parameters, **environment: str) -> float:
    """Return the seconds from the start of a process to the end of its first sample interval."""
    started = time.time()
    return float(_run_in_child(_FIRST_SAMPLE, canonical_json(point), **environment)) - started


def _measure_peak_memory(point: Parameters) -> float:
    """Return the peak resident memory (MB) of a process that runs a short version of the point."""
    short = point.model_copy(update={"transient": 1.0, "average": 4.0})
    with tempfile.TemporaryDirectory() as folder:
        return float(_run_in_child(_PEAK_MEMORY, canonical_json(short), f"{folder}/run.nc"))


def _run_in_child(code: str, *arguments: str, **environment: str) -> str:
    """Run a few lines in a fresh interpreter and return their output."""
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=os.environ | environment,
        cwd=Path(__file__).parents[1],
        check=True,
        capture_output=True,
        text=True,
    ).stdout


if __name__ == "__main__":
    main()
