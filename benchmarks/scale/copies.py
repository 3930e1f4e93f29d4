"""What a large study costs beside its runs, all of which are copies of one.

One point of the belt is run. Its file, under the names and with the parameters of all others, makes
a study whose numbers mean nothing and whose size is that of a real one.
"""

import shutil
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import netCDF4

from benchmarks.scale.cost import ROOT, cost
from benchmarks.scale.grid import ROW, write_study
from sim.base.seals import append_summary, read_summary, seal
from sim.engine.run import run_point
from sim.parameters import Parameters, parse_point, point_id
from sim.study.load import load_study

#: Points that are added to a finished study.
ADDED = 10

#: Parameters in which the points differ.
VARIED = ("frequency", "amplitude")


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


def measure(folder: Path, rows: int, replicates: int, processes: int) -> None:
    """Make a study of copies in a folder and print what its commands cost."""
    template = folder / "template.nc"
    run_point(parse_point({"system": "belt", "replicates": replicates}, ""), template)

    def tell(what: str, *words: str) -> None:
        found = cost(folder, *words)
        numbers = f"{found.cpu:.1f} s | {found.wall:.1f} s | {found.memory:.0f} MB"
        print(f"| {what} | {numbers} |", flush=True)

    print(f"{rows * ROW:,} points of {replicates} replicates, {processes} processes\n")
    print("| what | processor time | on the clock | memory |\n| --- | ---: | ---: | ---: |")
    belt = {"replicates": replicates}
    study = write_study(folder, rows, belt)
    dataset = ("sim", "dataset", study.name, "-j", str(processes))
    dry = ("snakemake", "-n", "--quiet", "-s", str(ROOT / "Snakefile"), "--configfile", study.name)
    tell("`points`", "sim", "points", study.name)
    tell("`status`, none run", "sim", "status", study.name)
    tell("`snakemake -n`, none run", *dry)
    fill(folder, study, template, processes)
    tell("`status`, all run", "sim", "status", study.name)
    tell("`dataset` from all run files", *dataset)
    tell("`dataset`, nothing new", *dataset)
    write_study(folder, rows, belt, added=ADDED)
    fill(folder, study, template, processes)
    tell(f"`dataset`, {ADDED} more points", *dataset)
