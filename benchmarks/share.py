"""The share of a study's processor time that the compiled loops over time steps take.

    python -m benchmarks.share                          # 100 belts of default size and length
    python -m benchmarks.share --system chute --points 4
    python -m benchmarks.share --points 8 --repeats 3   # a short one, several times

A study of points that differ in one parameter is run from nothing by Snakemake on two cores, with
compiled code in the cache: the runs alone, and the whole study with dataset, claims, figures and
report. The run files hold the times of their loops.
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

#: By system: the parameter that varies, its first and last value, and the fixed parameters.
SWEEPS: dict[str, tuple[str, float, float, dict]] = {
    "belt": ("frequency", 15.0, 100.0, {}),
    "chute": ("angle", 15.0, 18.0, {"depth": 5}),
}

CORES = 2

STUDY = "share"
RESULTS = Path("results") / STUDY


def study(system: str, points: int, replicates: int = 1) -> dict:
    """Return a study of ``points`` points of a system."""
    name, first, last, fixed = SWEEPS[system]
    values = np.round(np.linspace(first, last, points), 3).tolist()
    series = {"name": name, "system": system, "grid": {name: values}}
    plots = [{"name": "velocity", "x": name}]
    defaults = {system: fixed | {"replicates": replicates}}
    return {"study": STUDY, "defaults": defaults, "series": [series], "plots": plots}


def processor_time() -> float:
    """Return the processor time (s) of all children that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run_targets(path: Path, *targets: str) -> float:
    """Make targets with Snakemake; return the processor time (s) that it and its jobs take."""
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
    arguments = parser.parse_args()
    shares = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(
            yaml.safe_dump(study(arguments.system, arguments.points, arguments.replicates))
        )
        subprocess.run([sys.executable, "-m", "sim", "warm", path], check=True)
        for _ in range(arguments.repeats):
            shutil.rmtree(RESULTS, ignore_errors=True)
            runs = run_targets(path, "runs")
            loops, rest = loop_time(), run_targets(path, "default")
            shares.append((loops / runs, loops / (runs + rest)))
            print(
                f"{arguments.points} points: loops {loops:.1f} s of {runs:.1f} s for the runs, "
                f"{runs + rest:.1f} s for the whole study"
            )
    runs_share, study_share = (statistics.median(column) for column in zip(*shares, strict=True))
    print(f"in the loops: {runs_share:.1%} of the runs, {study_share:.1%} of the study")


if __name__ == "__main__":
    main()
