"""Which share of a study's processor time is spent in the compiled loops over time steps.

    python -m benchmarks.share                          # 100 belts of default size and length
    python -m benchmarks.share --system chute --points 4
    python -m benchmarks.share --points 8 --repeats 3   # a short one, several times

A study of points that differ in one parameter is run from nothing by Snakemake on two cores, with
compiled code in the cache: the runs alone, and the whole study with dataset, claims, figures and
report. The run files say how long their loops have taken.
"""

import argparse
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import netCDF4
import numpy as np
import yaml

#: By system: the parameter that differs, its first and last value, what else is said of the points.
SWEEPS: dict[str, tuple[str, float, float, dict]] = {
    "belt": ("frequency", 15.0, 100.0, {}),
    "chute": ("angle", 15.0, 18.0, {"depth": 5}),
}

CORES = 2

STUDY = "share"
RESULTS = Path("results") / STUDY


def study(system: str, points: int, replicates: int = 1) -> dict:
    """Return a study of so many points of a system."""
    name, first, last, fixed = SWEEPS[system]
    values = np.round(np.linspace(first, last, points), 3).tolist()
    series = {"name": name, "system": system, "grid": {name: values}}
    plots = [{"name": "velocity", "x": name}]
    defaults = {system: fixed | {"replicates": replicates}}
    return {"study": STUDY, "defaults": defaults, "series": [series], "plots": plots}


def processor_time() -> float:
    """Return the processor time (s) of all children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def ran(path: Path, *targets: str) -> float:
    """Return the processor time (s) that Snakemake and its jobs take to make some targets."""
    before = processor_time()
    command = [sys.executable, "-m", "snakemake", "--cores", str(CORES), "--quiet", "all"]
    subprocess.run([*command, "--configfile", path, "--", *targets], check=True)
    return processor_time() - before


def loop_time() -> float:
    """Return the processor time (s) that the loops of all runs of the study have taken."""
    total = 0.0
    for path in (RESULTS / "runs").glob("*.nc"):
        with netCDF4.Dataset(path) as file:
            total += float(file["loop_time"][...].sum())
    return total


def main() -> None:
    """Print times and shares of each repeat, then the medians of the shares."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.share",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--system", choices=list(SWEEPS), default="belt")
    parser.add_argument("--points", type=int, default=100)
    parser.add_argument("--replicates", type=int, default=1, help="of each point")
    parser.add_argument("--repeats", type=int, default=1, help="of the measurement")
    given = parser.parse_args()
    shares = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(yaml.safe_dump(study(given.system, given.points, given.replicates)))
        subprocess.run([sys.executable, "-m", "sim", "warm", path], check=True)
        for _ in range(given.repeats):
            shutil.rmtree(RESULTS, ignore_errors=True)
            runs = ran(path, "runs")
            loops, rest = loop_time(), ran(path, "default")
            shares.append((loops / runs, loops / (runs + rest)))
            print(
                f"{given.points} points: loops {loops:.1f} s of {runs:.1f} s for the runs, "
                f"{runs + rest:.1f} s for the whole study"
            )
    runs_share, study_share = (statistics.median(column) for column in zip(*shares, strict=True))
    print(f"in the loops: {runs_share:.1%} of the runs, {study_share:.1%} of the study")


if __name__ == "__main__":
    main()
