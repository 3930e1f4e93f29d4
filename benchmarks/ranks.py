"""A large flow on threads of Talus and on processes of LAMMPS: time per step, memory, means.

    python -m benchmarks.ranks                 # a million spheres at depth 10
    python -m benchmarks.ranks --cell 100 --steps 200
    python -m benchmarks.ranks --settle 6500 --folder bed

Each variant runs in a process of its own, from the random packing of the start or from the same
settled bed, in which contacts begin anew. States after stretches stay in the folder: the same
command goes on from there.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

from sim.base.files import atomic_write
from sim.engine.dynamics.cells import LIST_FULL
from sim.engine.states import flatten, refill, subtree
from sim.engine.systems import build
from sim.parameters import parse_point

#: Threads and processes that are measured.
VARIANTS = {
    "Talus, 1 thread": {"threads": 1},
    "Talus, 2 threads": {"threads": 2},
    "LAMMPS, 1 process": {"engine": "lammps"},
    "LAMMPS, 2 processes": {"engine": "lammps", "ranks": 2},
}

#: What settles a bed, in how many stretches, and how many copies of it along each side of the cell
#: are laid out; a random velocity (√(gσ)) sets them apart.
BED, BED_STRETCHES, COPIES, AGITATION = {"threads": 1}, 10, 4, 0.1

#: What is compared: means over a stretch, and the state at its end (SI).
MEANS = ("mean_velocity", "kinetic_energy", "rotational_energy", "height_of_mass")


def flow(cell: float, **values):
    """Return a flow in its initial state."""
    shared = {"system": "chute", "law": "spring_dashpot", "depth": 10, "stiffness": 117}
    point = {**shared, "cell": cell, "orientations": False, **values}
    return build(parse_point(point, "ranks"), 0)


def lay(system, bed) -> None:
    """Put copies of a settled bed into a flow that has not begun."""
    particles, spheres, rng = bed.snapshot(), system.spheres, np.random.default_rng(0)
    position, velocity, spin = (
        np.tile(particles[name].T, COPIES**2)
        for name in ("position", "particle_velocity", "particle_spin")
    )
    places = np.indices((COPIES, COPIES)).reshape(2, -1).repeat(bed.spheres.radius.size, axis=1)
    spheres.position[:] = position
    spheres.position[:2] += places * bed.box.length[0]
    agitation = AGITATION * system.parameters.velocity_unit
    spheres.velocity[:] = velocity + rng.normal(0.0, agitation, velocity.shape)
    spheres.rim[:] = spheres.radius * spin
    if hasattr(system, "place"):
        system.place[0] = spheres.position[0] % system.box.length[0]


def follow(system, steps: int, stretches: int, path: Path) -> list[dict[str, float]]:
    """Return per stretch of steps the seconds per step, the memory (MB) and the means."""

    def moving():
        return {name: getattr(system, name) for name in system.state_names}

    rows = []
    if path.is_file():
        with np.load(path) as file:
            state = {name: value if value.ndim else value.item() for name, value in file.items()}
        rows = json.loads(state["rows"])
        for name, value in refill(moving(), subtree("moving", state)).items():
            setattr(system, name, value)
    else:
        system._run(2)
    system.sample_steps, own = steps, psutil.Process()
    while len(rows) < stretches:
        system.loop.sums[:] = 0.0
        started = time.perf_counter()
        target = int(system.loop.step[0]) + steps - 1
        while system._advance(target - int(system.loop.step[0])) == LIST_FULL:
            system._enlarge_list()
        seconds = (time.perf_counter() - started) / (steps - 1)
        processes = own, *own.children(recursive=True)
        memory = sum(one.memory_info().rss for one in processes) / 1e6
        rows.append({"seconds": seconds, "memory": memory, **system.advance()})
        state = flatten({"moving": moving(), "rows": json.dumps(rows)})
        with atomic_write(path, durable=False) as part, part.open("wb") as file:
            np.savez(file, **state)
    return rows


def measure(given: argparse.Namespace, name: str) -> None:
    """Follow one variant, and print its rows."""
    # Places that a bed will take anyway are drawn sooner where they are few.
    start = {"initial_packing": 0.1} if given.settle else {}
    system = flow(given.cell, **start, **VARIANTS[name])
    path = given.folder / f"{name}.state"
    if given.settle and not path.is_file():
        bed = flow(given.cell / COPIES, **BED)
        follow(bed, given.settle // BED_STRETCHES, BED_STRETCHES, given.folder / "bed.state")
        lay(system, bed)
    print(json.dumps(follow(system, given.steps, given.stretches, path)))


def main() -> None:
    """Print one line per variant, and its means after each stretch."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ranks", description=__doc__)
    parser.add_argument("--cell", type=float, default=316.0, help="side of the cell in diameters")
    parser.add_argument("--steps", type=int, default=50, help="steps of a stretch")
    parser.add_argument("--stretches", type=int, default=3)
    parser.add_argument("--settle", type=int, default=0, help="steps in which a bed settles before")
    parser.add_argument("--folder", type=Path, help="where states stay (default: nowhere)")
    parser.add_argument("--variant", action="append", choices=VARIANTS, help="default: all")
    parser.add_argument("--only", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.only:
        return measure(given, given.only)
    number = round(10 * given.cell**2)
    print(f"{number:,} spheres: ms per step (least and most of the stretches), memory; SI means")
    with tempfile.TemporaryDirectory() as folder:
        for name in given.variant or VARIANTS:
            words = [*sys.argv[1:], "--folder", str(given.folder or folder), "--only", name]
            command = [sys.executable, "-m", "benchmarks.ranks", *words]
            lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            rows = json.loads(lines.splitlines()[-1])
            times = [1e3 * row["seconds"] for row in rows]
            memory = max(row["memory"] for row in rows)
            print(f"{name:22}{min(times):8.1f} - {max(times):.1f} ms{memory:10,.0f} MB", flush=True)
            for row in rows:
                print(" " * 22, *(f"{key} {row[key]:.9g}" for key in MEANS), flush=True)
    return None


if __name__ == "__main__":
    main()
