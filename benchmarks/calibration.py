"""Calibrations of made-up materials: how often intervals hold them, and what one takes.

`python -m benchmarks.calibration` prints in how many of 40 materials the 95 % interval of each
parameter holds the truth; 33 to 40 are wanted. It also prints how evenly the truth lies among the
draws of the posterior (Talts et al. 2018, arXiv:1804.06788): a probability below 0.01 says that
posteriors are too wide, too narrow or shifted. A material that fits nowhere does not count as held.

`python -m benchmarks.calibration --runs FOLDER` goes from a study file to a posterior: a material
is "measured" at three angles by runs of the same lengths and cells as the study's, with made-up
errors. It prints processor time, time, and the answer.
"""

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from scipy.stats import chisquare

from sim.report.results import load
from sim.surrogates.posterior import calibrate, summarize
from sim.surrogates.storage import load_posterior
from tests.surrogates.predictors import RANGES, made_measurements

#: Materials, seed of the first, and bins of the ranks.
MATERIALS, SEED, BINS = 40, 1000, 4

#: The material that runs "measure", and the relative error of its measurements.
MATERIAL, ERROR = {"friction": 0.5, "restitution": 0.85}, 0.03

#: Settings that the material's runs and those of the study share.
SETTINGS = "defaults:\n  chute: {depth: 3, cell: 6, transient: 80, average: 120, replicates: 2}\n"

TRUTH = f"""\
study: material
{SETTINGS}
series:
  - name: measured
    system: chute
    base: {MATERIAL}
    grid: {{angle: [15, 16.5, 18]}}
"""

STUDY = f"""\
study: beads
{SETTINGS}
series:
  - name: wide
    system: chute
    design:
      kind: sobol
      points: 64
      over: {{friction: [0.35, 0.7], restitution: [0.65, 0.95], angle: [15, 18]}}
surrogate:
  - {{name: speed, series: wide, regimes: [steady, mixed, undetermined]}}
calibrate:
  - name: material
    data: measured.csv
    surrogate: speed
    parameters: {{friction: [0.35, 0.7], restitution: [0.65, 0.95]}}
"""


def ranks_and_intervals(
    materials: int = MATERIALS,
) -> tuple[dict[str, list[float]], dict[str, int]]:
    """Return the rank of each truth among the draws, 0 to 1, and how many intervals hold it."""
    ranks: dict[str, list[float]] = {name: [] for name in RANGES}
    held = dict.fromkeys(RANGES, 0)
    for seed in range(SEED, SEED + materials):
        truth, calibration = made_measurements(seed)
        groups = calibrate(calibration)
        if "posterior" not in groups:
            continue
        rows = summarize(groups).set_index("parameter")
        for name, value in truth.items():
            ranks[name].append(float(np.mean(groups["posterior"][name].to_numpy() < value)))
            held[name] += bool(rows["low"][name] <= value <= rows["high"][name])
    return ranks, held


def measure(folder: Path) -> None:
    """Run the material in a folder, and write its measurements with made-up errors."""
    run_study(folder, "material", TRUTH)
    grid = load(folder / "results" / "material").to_grid()
    errors = ERROR * np.abs(grid.values)
    made = grid.values + errors * np.random.default_rng(SEED).normal(size=errors.size)
    rows = [
        f"{a:g}, {v:.5g}, {e:.3g}\n" for a, v, e in zip(grid["angle"], made, errors, strict=True)
    ]
    text = "angle (deg), velocity (m/s), velocity_error (m/s)\n" + "".join(rows)
    (folder / "measured.csv").write_text(text)


def run_study(folder: Path, name: str, text: str) -> tuple[float, float]:
    """Run a study in a folder on two cores; return processor time and time (s)."""
    (folder / f"{name}.yaml").write_text(text)
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, "-m", "sim", "study", f"{name}.yaml", "--cores", "2"]
    subprocess.run(command, cwd=folder, check=True)
    elapsed, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, elapsed


def from_runs(folder: Path) -> None:
    """Calibrate the material from a study file, and print what that takes and gives."""
    folder.mkdir(parents=True)
    measure(folder)
    processor, elapsed = run_study(folder, "beads", STUDY)
    groups = load_posterior(folder / "results" / "beads" / "calibration" / "material.nc")
    print(f"processor time {processor:.0f} s, time {elapsed:.0f} s")
    if "posterior" not in groups:
        print("no parameters in the ranges fit")
        return
    for row in summarize(groups).itertuples():
        truth = MATERIAL[str(row.parameter)]
        print(f"{row.parameter}: {row.median:.3f} ({row.low:.3f} to {row.high:.3f}), truth {truth}")


def main() -> None:
    """Print how often intervals hold, or what a calibration from runs takes and gives."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=Path, metavar="FOLDER", help="a folder that is made")
    options = parser.parse_args()
    if options.runs:
        from_runs(options.runs)
        return
    ranks, held = ranks_and_intervals()
    for name, values in ranks.items():
        counts, _ = np.histogram(values, BINS, (0, 1))
        print(
            f"{name}: {held[name]} of {MATERIALS} held, {MATERIALS - len(values)} fit nowhere; "
            f"ranks {counts.tolist()}, probability {chisquare(counts).pvalue:.2g}"
        )


if __name__ == "__main__":
    main()
