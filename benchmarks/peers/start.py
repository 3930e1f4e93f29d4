"""Start-up: from a new process to the first step, and a further run in a living process."""

import subprocess
import sys
import time
from statistics import median

from benchmarks.peers.chute_input import chute_request, chute_state
from benchmarks.peers.client import Client
from benchmarks.peers.settings import Settings
from sim.engine.systems import build
from sim.parameters import Parameters, canonical_json, parse_point

#: The flow that is started: 500 spheres.
POINT = {"system": "chute", "depth": 5, "cell": 10, "stiffness": 117}

#: Starts of which the median counts.
REPEATS = 5

_OURS = """
import json, sys
from sim.parameters import parse_point
from sim.engine.systems import build
build(parse_point(json.loads(sys.argv[1]), "start"), 0).advance()
print("ready", flush=True)
"""


def our_start(p: Parameters) -> float:
    """Return the seconds from the start of a process to the end of its first sample interval."""
    started = time.perf_counter()
    command = [sys.executable, "-c", _OURS, canonical_json(p)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        if process.stdout.readline() != "ready\n":
            raise RuntimeError("the first steps failed, see the message above")
        return time.perf_counter() - started


def their_start(p: Parameters, snapshot: dict) -> tuple[float, float]:
    """Return the seconds from the start of a LAMMPS process to its first steps, and of a set-up.

    As many steps as ours has in a sample interval. The second number is that of the same flow
    once more in the same process, from ``clear`` on.
    """
    request, state = chute_request(p, snapshot, Settings()), chute_state(p, snapshot, Settings())
    started = time.perf_counter()
    with Client() as client:
        client.setup(request, state)
        client.ask("run", steps=p.sample_steps)
        first = time.perf_counter() - started
        return first, client.setup(request, state)


def our_setup() -> float:
    """Return the seconds that parameters, particles and lists of a further run take."""
    started = time.perf_counter()
    build(parse_point(POINT, "set-up"), 0)
    return time.perf_counter() - started


def main() -> None:
    """Print both engines' times."""
    p = parse_point(POINT, "start")
    snapshot = build(p, 0).snapshot()
    our_start(p)  # compiles what is not compiled yet
    ours = [our_start(p) for _ in range(REPEATS)]
    theirs = [their_start(p, snapshot) for _ in range(REPEATS)]
    our_setups = [our_setup() for _ in range(REPEATS)]
    print(f"{'':46}Talus   LAMMPS")
    first = median(first for first, _ in theirs)
    print(f"process start to first {p.sample_steps} steps, s{median(ours):17.2f}{first:9.2f}")
    again = median(again for _, again in theirs)
    print(f"set-up of a further run, ms{1e3 * median(our_setups):24.1f}{1e3 * again:9.1f}")
