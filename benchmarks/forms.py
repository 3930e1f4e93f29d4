"""What forms of the velocity are worth: ten designs of 48 belts, and fresh belts of two beds each.

`python -m benchmarks.forms` prints the figures of docs/surrogates.md from `belts.csv` beside it:
velocity (m/s), its standard error and regime of each bed, in the ranges of `config/explore.yaml`.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from sim.base.statistics import MANY, student
from sim.parameters.observables import forms
from sim.study.design import Axis
from sim.surrogates.fit import fit_process
from sim.surrogates.sample import Frame, unit_cube

AXES = (Axis("frequency", 15, 100), Axis("amplitude", 0.5, 1.5), Axis("vibration_angle", 30, 60))
NAMES = [axis.name for axis in AXES]

#: Parameters that all belts have in common, in SI.
FIXED = {"diameter": 1e-3, "gravity": 10.0}

#: Regimes that surrogates leave out by default.
LEFT_OUT = ("accelerating", "arrested")


def main() -> None:
    """Print error (mm/s), share of fresh belts within 95 % and form, by what counts and forms."""
    beds = pd.read_csv(Path(__file__).with_suffix("").with_name("belts.csv"))
    fresh = beds[beds["series"] == "fresh"].groupby(NAMES, sort=False)["velocity"]
    truth, scatter = fresh.mean(), np.sqrt((fresh.std() ** 2).mean() / 2)
    places = _places(truth.reset_index())
    suggested = [Frame(form, AXES, FIXED) for form in forms("belt", "velocity").values()]
    print("the scatter of the fresh means is", f"{1000 * scatter:.1f} mm/s")
    rows = []
    for series, every in beds[beds["series"] != "fresh"].groupby("series"):
        counted = every[~every["regime"].isin(LEFT_OUT)]
        for (counts, runs), frames in (
            (pair, frames)
            for pair in (("default", counted), ("all", every))
            for frames in ([], suggested)
        ):
            variance = runs["velocity_error"].to_numpy() ** 2
            process = fit_process(
                _places(runs), runs["velocity"].to_numpy(), variance, True, frames
            )
            mean, error = process.predict(places)
            apart = np.abs(mean - truth.to_numpy())
            held = np.mean(apart < student(MANY) * np.hypot(error, scatter))
            form = process.frame.form.name if process.frame else "plain"
            rms = 1000 * np.sqrt(np.mean(apart**2))
            rows.append((series, counts, "suggested" if frames else "plain", rms, held, form))
    table = pd.DataFrame(rows, columns=["design", "count", "forms", "rms", "held", "form"])
    print(table.groupby(["count", "forms"])[["rms", "held"]].agg(["mean", "min", "max"]).round(2))
    print(table.groupby(["count", "forms"])["form"].value_counts())


def _places(rows: pd.DataFrame) -> np.ndarray:
    return unit_cube(AXES, {name: rows[name].to_numpy() for name in NAMES})


if __name__ == "__main__":
    main()
