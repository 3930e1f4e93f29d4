"""What a workflow shows while it runs: a line per point that has finished, a bar on a terminal."""

import os
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

from tqdm import tqdm

from sim.base.words import duration
from sim.study.cost import estimate
from sim.study.load import Study

#: Seconds between two looks at the folder of runs.
PAUSE = 1.0

#: Points of which each is told where no terminal shows a bar; of more, failures alone, and how far
#: the study is after every twentieth part.
FEW = 30

#: What a bar shows on a terminal.
BAR = "{desc}: {n_fmt} of {total_fmt} points |{bar:30}| {postfix}"


class Watch(threading.Thread):
    """Looks at the run files and logs of a study from a thread until it is told to end.

    Parameters
    ----------
    study : Study
        The study. Points of rounds of refinement are told when they are there.
    folder : Path
        Its results: ``runs`` and ``logs/runs``.
    """

    def __init__(self, study: Study, folder: Path):
        super().__init__(daemon=True)
        self._runs, self._logs = folder / "runs", folder / "logs" / "runs"
        self._seconds = {
            point.id: estimate(point.parameters).core_seconds for point in study.points.values()
        }
        self._over = threading.Event()
        self._began = time.monotonic()
        self._known = self._look()
        self._failed, self._name = 0, study.name
        there = self._known.keys() & self._seconds.keys()
        self._left = sum(self._seconds[name] for name in self._seconds.keys() - there)
        self._spent = 0.0
        self._told = 20 * len(there) // max(1, len(self._seconds))
        self._bar = tqdm(
            desc=study.name,
            total=len(self._seconds),
            initial=len(there),
            bar_format=BAR,
            file=sys.stderr,
            disable=not sys.stderr.isatty(),
        )

    def run(self) -> None:
        """Look again and again."""
        while not self._over.wait(PAUSE):
            self._tell()

    def end(self) -> None:
        """Tell what has finished since, and end."""
        self._over.set()
        if self.is_alive():
            self.join()
        self._tell()
        self._bar.close()

    def write(self, line: str) -> None:
        """Write a line, above the bar if there is one."""
        self._bar.write(line, file=sys.stderr)

    def _look(self) -> dict[str, int]:
        """Return the points with a run file, and the number of the file, new with each file."""
        found = {}
        with suppress(FileNotFoundError), os.scandir(self._runs) as entries:
            for entry in entries:
                if entry.name.endswith(".nc") and not entry.name.startswith("."):
                    with suppress(FileNotFoundError):
                        found[entry.name.removesuffix(".nc")] = entry.inode()
        return found

    def _tell(self) -> None:
        """Write a line for each point that has finished since the last look; move the bar."""
        found = self._look()
        for name in found:
            if self._known.get(name) != found[name]:
                line = self._result(name)
                failed = "failed" in line
                self._failed += failed
                if failed or not self._bar.disable or len(self._seconds) <= FEW:
                    self.write(line)
                if name not in self._known:
                    seconds = self._seconds.get(name, 0.0)
                    self._left, self._spent = self._left - seconds, self._spent + seconds
                    self._bar.update(name in self._seconds)
        self._known |= found
        self._bar.set_postfix_str(self._state())
        done, all_ = len(found.keys() & self._seconds.keys()), len(self._seconds)
        if self._bar.disable and all_ > FEW and 20 * done // all_ > self._told:
            self._told = 20 * done // all_
            print(f"{self._name}: {done} of {all_} points, {self._state()}", file=sys.stderr)

    def _result(self, name: str) -> str:
        """Return the line with the result in the log of a run."""
        with suppress(OSError):
            lines = (self._logs / f"{name}.log").read_text(encoding="utf-8").splitlines()
            results = [line for line in lines if line.startswith(f"{name}: ")]
            if results:
                return results[-1]
        return f"{name}: done"

    def _state(self) -> str:
        """Say how many points are running and have failed, and how long the rest may take."""
        running = sum(1 for _ in self._runs.glob(".*.progress"))
        text = f"{running} running, {self._failed} failed"
        if self._spent > 0 and self._left > 0:
            seconds = (time.monotonic() - self._began) * self._left / self._spent
            text += f", about {duration(seconds)} left"
        return text
