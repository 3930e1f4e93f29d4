"""What a large study costs from its first run to its report, killed halfway and started again.

Its points are as small as they can be, so that what is measured is all that is not computing.
"""

import csv
from pathlib import Path

from benchmarks.scale.cost import ROOT, Cost, cost
from benchmarks.scale.grid import ROW, write_study
from sim.base.seals import read_summary

#: A point: some hundredths of a second of computing.
POINT = {"beads": 4, "width": 5, "transient": 1, "average": 2}

PLOTS = [
    {"name": "map", "kind": "map", "x": "frequency", "y": "amplitude", "colour": "velocity"},
    {"name": "all", "x": "granular_temperature", "y": "velocity"},
]

#: Jobs after the runs.
LAST = ("dataset", "claims", "figures", "report")


def measure(folder: Path, rows: int, replicates: int, processes: int) -> None:
    """Run a study in a folder, killed once half of its runs are there; print what it cost."""
    study = write_study(folder, rows, POINT | {"replicates": replicates}, plots=PLOTS)
    results = folder / "results" / "scale"
    snakemake = ("snakemake", "--cores", str(processes), "--snakefile", str(ROOT / "Snakefile"))
    snakemake += ("--configfile", study.name, "--")
    print(f"{rows * ROW:,} points of {replicates} replicates, {processes} processes\n")
    print("| what | processor time | on the clock | memory | of the command alone |")
    print("| --- | ---: | ---: | ---: | ---: |")
    cost(folder, "sim", "warm", study.name)

    half = rows * ROW // 2
    first = cost(folder, *snakemake, "runs", until=lambda: len(run_files(results)) >= half)
    finished = run_files(results)
    tell(f"the first {len(finished):,} runs, then killed", first)
    second = cost(folder, *snakemake, "runs")
    tell("started again: the others", second)
    after = run_files(results)
    kept = sum(after[name] == inode for name, inode in finished.items())
    tell("dataset, claims, figures, report", cost(folder, *snakemake))
    for name in LAST:
        print(f"| {name} alone | | {wall_time(results, name):.1f} s | | |", flush=True)
    tell("started again: nothing to do", cost(folder, *snakemake))
    tell("`status`", cost(folder, "sim", "status", study.name))

    loops = sum(map(loop_time, (results / "runs").glob("*.nc")))
    runs = first.cpu + second.cpu
    print(f"\n{kept:,} of {len(finished):,} runs from before the kill are kept")
    print(f"in the loops: {loops:.0f} s, {loops / runs:.1%} of what the runs cost")
    print(f"beside them: {1e3 * (runs - loops) / len(after):.0f} ms per point")
    for name in ("results/scale/runs", "results/scale", ".snakemake"):
        files = [path for path in (folder / name).rglob("*") if path.is_file()]
        size = sum(path.stat().st_blocks * 512 for path in files)
        print(f"{name}: {len(files):,} files, {size / 1e6:,.0f} MB")


def tell(what: str, found: Cost) -> None:
    """Print a row of the table."""
    times = f"{found.cpu:.1f} s | {found.wall:.1f} s"
    print(f"| {what} | {times} | {found.memory:.0f} MB | {found.own:.0f} MB |", flush=True)


def run_files(results: Path) -> dict[str, int]:
    """Return the names of the run files that are there, and which file each is."""
    return {path.name: path.stat().st_ino for path in (results / "runs").glob("[!.]*.nc")}


def wall_time(results: Path, job: str) -> float:
    """Return the time on the clock (s) that Snakemake has noted of a job.

    What it notes of processor time and memory are samples, half a minute apart.
    """
    with (results / "benchmarks" / f"{job}.tsv").open(encoding="utf-8") as file:
        (row,) = csv.DictReader(file, delimiter="\t")
    return float(row["s"])


def loop_time(path: Path) -> float:
    """Return the processor time (s) that the loops of a run have taken."""
    summary = read_summary(path) or {}
    return sum(summary["scalars"]["loop_time"])
