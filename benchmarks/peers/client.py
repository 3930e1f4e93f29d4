"""The parent's end of a LAMMPS process (`worker`)."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

WORKER = Path(__file__).parent / "worker.py"


class Client:
    """A LAMMPS process that stays alive between requests; use it in a ``with`` statement."""

    def __init__(self):
        command = [sys.executable, str(WORKER)]
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
            text=True,
        )
        self.folder = tempfile.TemporaryDirectory()

    def __enter__(self):
        return self

    def __exit__(self, *error) -> None:
        self.close()

    def close(self) -> None:
        """Let the process end and wait for it."""
        self.process.stdin.close()
        self.process.wait()
        self.folder.cleanup()

    def ask(self, do: str, **request) -> dict:
        """Send one request and return its answer."""
        print(json.dumps({"do": do, **request}), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            raise RuntimeError(f"LAMMPS ended during {do!r}, see its message above")
        return json.loads(answer)

    def setup(self, request: dict, state: dict[str, np.ndarray]) -> float:
        """Hand over commands and particles; return the seconds that LAMMPS took to be ready."""
        path = Path(self.folder.name) / "state.npz"
        np.savez(path, **state)
        return self.ask("setup", state=str(path), **request)["seconds"]

    def record(self, steps: int, samples: int) -> dict[str, np.ndarray]:
        """Run ``samples`` stretches of ``steps`` and return what `worker.Worker.record` wrote.

        Raises ``RuntimeError`` when LAMMPS may have missed contacts.
        """
        path = Path(self.folder.name) / "record.npz"
        answer = self.ask("record", steps=steps, samples=samples, path=str(path))
        if answer["dangerous"]:
            raise RuntimeError("LAMMPS renewed its neighbor list too late")
        with np.load(path) as record:
            return dict(record)
