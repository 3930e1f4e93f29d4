"""A large flow on threads of Talus and on processes of LAMMPS: time per step, and memory.

    python -m benchmarks.ranks                 # a million spheres at depth 10
    python -m benchmarks.ranks --cell 100 --steps 200

Each variant runs in a process of its own, from the random packing of the start.
"""

import argparse
import json
import subprocess
import sys
import time

import psutil

from sim.engine.systems import build
from sim.parameters import parse_point

#: Threads and processes that are measured.
VARIANTS = {
    "Talus, 1 thread": {"threads": 1},
    "Talus, 2 threads": {"threads": 2},
    "LAMMPS, 1 process": {"engine": "lammps"},
    "LAMMPS, 2 processes": {"engine": "lammps", "ranks": 2},
}


def measure(cell: float, steps: int, **values) -> None:
    """Print the seconds of each of three stretches, and the memory of all processes (MB)."""
    shared = {"system": "chute", "law": "spring_dashpot", "depth": 10, "stiffness": 117}
    system = build(
        parse_point({**shared, "cell": cell, "orientations": False, **values}, "ranks"), 0
    )
    system._run(2)
    seconds = []
    for _ in range(3):
        started = time.perf_counter()
        system._advance_to(int(system.loop.step[0]) + steps)
        seconds.append(time.perf_counter() - started)
    own = psutil.Process()
    memory = sum(one.memory_info().rss for one in (own, *own.children(recursive=True)))
    print(json.dumps([seconds, memory / 1e6]))


def main() -> None:
    """Print one line per variant."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ranks", description=__doc__)
    parser.add_argument("--cell", type=float, default=316.0, help="side of the cell in diameters")
    parser.add_argument("--steps", type=int, default=50, help="steps of a stretch")
    parser.add_argument("--only", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.only:
        return measure(given.cell, given.steps, **VARIANTS[given.only])
    number = round(10 * given.cell**2)
    print(f"{number:,} spheres: ms per step (least and most of three stretches), memory")
    for name in VARIANTS:
        words = ["--cell", str(given.cell), "--steps", str(given.steps), "--only", name]
        command = [sys.executable, "-m", "benchmarks.ranks", *words]
        lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        seconds, memory = json.loads(lines.splitlines()[-1])
        least, most = (1e3 * value / given.steps for value in (min(seconds), max(seconds)))
        print(f"{name:22}{least:8.1f} - {most:.1f} ms{memory:10,.0f} MB", flush=True)
    return None


if __name__ == "__main__":
    main()
