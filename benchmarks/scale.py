"""What a large study costs beside its runs: ``python -m benchmarks.scale`` prints a table.

One point of the belt is run. Its file, under the names and with the parameters of all others, makes
a study whose numbers mean nothing and whose size is that of a real one. Of each command it tells
the processor time of all its processes, the time on the clock, and the most memory that its
processes held together.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

import netCDF4
import psutil
import yaml

from sim.base.files import seal
from sim.base.summary import append_summary, read_summary
from sim.engine.run import run_point
from sim.parameters import Parameters, parse_point, point_id
from sim.study.load import load_study

ROOT = Path(__file__).parents[1]

#: Amplitudes to a frequency, and points that are added to a finished study.
ROW, ADDED = 100, 10

#: Parameters in which the points differ.
VARIED = ("frequency", "amplitude")

#: Seconds between two looks at the memory of a command.
PAUSE = 0.1


class Cost(NamedTuple):
    """Processor time (s), time on the clock (s) and memory (MB) of a command."""

    cpu: float
    wall: float
    memory: float


def write_study(folder: Path, rows: int, replicates: int, added: int = 0) -> Path:
    """Write a study of so many rows of points and, in a series of their own, some more."""
    grid = {
        "frequency": [20 + number for number in range(rows)],
        "amplitude": [1 + number / ROW for number in range(ROW)],
    }
    series = [{"name": "beds", "system": "belt", "grid": grid}]
    if added:
        frequencies = [20 + number for number in range(added)]
        more = {"base": {"amplitude": 3}, "grid": {"frequency": frequencies}}
        series.append({"name": "more", "system": "belt", **more})
    study = {"study": "scale", "defaults": {"belt": {"replicates": replicates}}, "series": series}
    path = folder / "scale.yaml"
    path.write_text(yaml.safe_dump(study), encoding="utf-8")
    return path


def copy_run(template: Path, runs: Path, parameters: Parameters) -> None:
    """Write the run file of a point with the results of another one."""
    path = runs / f"{point_id(parameters)}.nc"
    shutil.copyfile(template, path)
    with netCDF4.Dataset(path, "a") as file:
        file.point_id = path.stem
        for name in VARIED:
            file[name][...] = getattr(parameters, name)
    summary = read_summary(template) or {}
    summary["attributes"]["point_id"] = path.stem
    append_summary(path, summary)
    seal(path)


def fill(folder: Path, study: Path, template: Path, processes: int) -> None:
    """Write the run files of a study that are not there yet."""
    runs = folder / "results" / "scale" / "runs"
    runs.mkdir(parents=True, exist_ok=True)
    points = load_study(study, None).points
    missing = [one.parameters for key, one in points.items() if not (runs / f"{key}.nc").exists()]
    with ProcessPoolExecutor(processes) as pool:
        list(pool.map(partial(copy_run, template, runs), missing, chunksize=50))


def cost(folder: Path, *words: str) -> Cost:
    """Run a command of this environment in a folder; return what it cost.

    Raises ``CalledProcessError`` when it fails.
    """
    command = [sys.executable, "-m", *words]
    began, most = time.perf_counter(), 0.0
    with (folder / "output.log").open("wb") as log:
        process = subprocess.Popen(
            command, cwd=folder, stdout=log, stderr=log, env=os.environ | {"PYTHONPATH": str(ROOT)}
        )
    while not (ended := os.wait4(process.pid, os.WNOHANG))[0]:
        most = max(most, _memory(process.pid))
        time.sleep(PAUSE)
    _, status, usage = ended
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    wall = time.perf_counter() - began
    return Cost(usage.ru_utime + usage.ru_stime, wall, most / 1e6)


def _memory(pid: int) -> float:
    """Return the bytes that a process and its descendants hold, what they share counted once."""
    total = 0.0
    with suppress(psutil.Error):
        first = psutil.Process(pid)
        for each in (first, *first.children(recursive=True)):
            with suppress(psutil.Error):
                total += each.memory_full_info().pss
    return total


def measure(folder: Path, template: Path, rows: int, replicates: int, processes: int) -> None:
    """Make a study in a folder and print what its commands cost."""

    def tell(what: str, *words: str) -> None:
        found = cost(folder, *words)
        numbers = f"{found.cpu:.1f} s | {found.wall:.1f} s | {found.memory:.0f} MB"
        print(f"| {what} | {numbers} |", flush=True)

    print(f"{rows * ROW:,} points of {replicates} replicates, {processes} processes\n")
    print("| what | processor time | on the clock | memory |\n| --- | ---: | ---: | ---: |")
    study = write_study(folder, rows, replicates)
    dataset = ("sim", "dataset", study.name, "-j", str(processes))
    dry = ("snakemake", "-n", "--quiet", "-s", str(ROOT / "Snakefile"), "--configfile", study.name)
    tell("`points`", "sim", "points", study.name)
    tell("`status`, none run", "sim", "status", study.name)
    tell("`snakemake -n`, none run", *dry)
    fill(folder, study, template, processes)
    tell("`status`, all run", "sim", "status", study.name)
    tell("`dataset` from all run files", *dataset)
    tell("`dataset`, nothing new", *dataset)
    write_study(folder, rows, replicates, ADDED)
    fill(folder, study, template, processes)
    tell(f"`dataset`, {ADDED} more points", *dataset)


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scale")
    parser.add_argument("--rows", type=int, default=100, help=f"of {ROW} points each")
    parser.add_argument("--replicates", type=int, default=5)
    parser.add_argument("-j", "--processes", type=int, default=2)
    parser.add_argument("--folder", type=Path, help="where to make it (default: a temporary one)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        template = Path(name) / "template.nc"
        run_point(parse_point({"system": "belt", "replicates": options.replicates}, ""), template)
        measure(Path(name), template, options.rows, options.replicates, options.processes)


if __name__ == "__main__":
    main()
