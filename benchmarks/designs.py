"""What a design is worth: surrogates of a few points beside full grids, on points neither has seen.

`python -m benchmarks.designs` reads the results of `config/explore.yaml` and prints the table of
docs/surrogates.md; `--picture FILE.svg` draws it. Errors are root mean squares over the fresh
points, less what the scatter of their own few beds adds.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import xarray as xr
from scipy.interpolate import RegularGridInterpolator

from sim.base.statistics import MANY, student
from sim.dataset.results import Results, load_current
from sim.study.load import Study, load_study
from sim.study.surrogate import SurrogateFile
from sim.surrogates.sample import points_of_mean, sample_points
from sim.surrogates.surrogate import Surrogate

SYSTEMS = ("belt", "chute")

#: Resamples of the fresh points for the interval of an error.
RESAMPLES = 2000


def spec_of(study: Study, system: str, series: str) -> SurrogateFile:
    """Return the surrogate of the velocity over a series, with the ranges of the design."""
    axes = study.axes[f"{system}-design"]
    (asked,) = (one for one in study.surrogates if one.system == system)
    return SurrogateFile(name=series, series=series, regimes=asked.regimes).about(system, axes)


def fresh_points(results: Results, study: Study, system: str) -> tuple[xr.Dataset, np.ndarray]:
    """Return the fresh points that have a mean, and their values of the axes (n, k)."""
    spec = spec_of(study, system, f"{system}-fresh")
    sample = sample_points(results, spec)
    sample = sample.isel(point=np.flatnonzero(points_of_mean(sample, spec.regimes)))
    return sample, np.column_stack([sample[axis.name].values for axis in spec.axes])


def error_of(prediction: np.ndarray, fresh: xr.Dataset) -> tuple[float, float, float]:
    """Return the error of predictions at fresh points, without the scatter of their beds.

    The ends of its 95 % interval follow: the bootstrap over the fresh points.
    """
    squares = (prediction - fresh["mean"].values) ** 2 - fresh["standard_error"].values ** 2
    squares = squares[np.isfinite(squares)]
    draws = np.random.default_rng(1).choice(squares, (RESAMPLES, squares.size))
    low, high = np.quantile(draws.mean(axis=1), (0.025, 0.975))
    middle, low, high = np.sqrt(np.maximum(0.0, (squares.mean(), low, high)))
    return float(middle), float(low), float(high)


def coverage_of(surrogate: Surrogate, fresh: xr.Dataset, x: np.ndarray) -> float:
    """Return the share of fresh means within the 95 % interval of their difference."""
    mean, error = surrogate.predict(x)
    width = float(student(MANY)) * np.hypot(error, fresh["standard_error"].values)
    return float(np.mean(np.abs(mean - fresh["mean"].values) <= width))


def interpolation(sample: xr.Dataset, spec: SurrogateFile, x: np.ndarray) -> np.ndarray:
    """Return linear interpolations of a full grid, along the logarithm where an axis has it."""
    names = [axis.name for axis in spec.axes]
    table = sample["mean"].to_series().to_frame().assign(**{n: sample[n].values for n in names})
    grid = table.set_index(names)["mean"].to_xarray()
    is_log = np.array([axis.scale == "log" for axis in spec.axes])
    ticks = [
        np.log(grid[name].values) if log else grid[name].values
        for name, log in zip(names, is_log, strict=True)
    ]
    places = np.where(is_log, np.log(x, where=is_log, out=np.ones_like(x)), x)
    return RegularGridInterpolator(ticks, grid.values)(places)


def rows_of(results: Results, study: Study, system: str) -> list[dict[str, object]]:
    """Return a row per way to predict: number of points, error (m/s), coverage."""
    fresh, x = fresh_points(results, study, system)
    rows: list[dict[str, object]] = []
    design, grid = (spec_of(study, system, f"{system}-{kind}") for kind in ("design", "grid"))
    sample = sample_points(results, design)
    for count in range(16, sample.sizes["point"] + 1, 16):
        surrogate = Surrogate.fit(design, sample.isel(point=slice(count)))
        coverage = coverage_of(surrogate, fresh, x)
        rows.append(
            _row(system, "design, surrogate", count, surrogate.predict(x)[0], fresh, coverage)
        )
    sample = sample_points(results, grid)
    count = sample.sizes["point"]
    surrogate = Surrogate.fit(grid, sample)
    coverage = coverage_of(surrogate, fresh, x)
    rows.append(_row(system, "grid, surrogate", count, surrogate.predict(x)[0], fresh, coverage))
    rows.append(_row(system, "grid, linear", count, interpolation(sample, grid, x), fresh, None))
    return rows


def _row(
    system: str,
    way: str,
    count: int,
    prediction: np.ndarray,
    fresh: xr.Dataset,
    share: float | None,
) -> dict[str, object]:
    error, low, high = error_of(prediction, fresh)
    return {
        "system": system,
        "prediction": way,
        "points": count,
        "error (mm/s)": 1000 * error,
        "low": 1000 * low,
        "high": 1000 * high,
        "fresh points within 95 %": share,
        "fresh points": fresh.sizes["point"],
    }


def draw(table: pd.DataFrame, path: Path) -> None:
    """Draw the error against the number of points, a panel per system."""
    looks = {
        "design, surrogate": ("o", "-", "#0072b2"),
        "grid, surrogate": ("s", "", "#009e73"),
        "grid, linear": ("^", "", "#d55e00"),
    }
    figure, panels = plt.subplots(1, 2, figsize=(7.2, 3.1), layout="constrained")
    for axes, (system, rows) in zip(panels, table.groupby("system", sort=False), strict=True):
        for way, each in rows.groupby("prediction", sort=False):
            marker, line, colour = looks[str(way)]
            style = {"marker": marker, "linestyle": line, "color": colour, "label": way}
            error = each["error (mm/s)"]
            bars = np.array([error - each["low"], each["high"] - error])
            axes.errorbar(each["points"], error, bars, capsize=2, clip_on=False, **style)
        axes.set(title=system, xlabel="points", ylim=(0, None), xlim=(0, None))
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("error at fresh points (mm/s)")
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False
    )
    figure.savefig(path)


def main() -> None:
    """Print the table, and draw it where a file is named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, default=Path("results"))
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    study = load_study("config/explore.yaml", options.results)
    results = load_current(study, options.results / study.name)
    table = pd.DataFrame([row for name in SYSTEMS for row in rows_of(results, study, name)])
    print(table.to_string(index=False, float_format="%.3g"))
    if options.picture:
        draw(table, options.picture)


if __name__ == "__main__":
    main()
