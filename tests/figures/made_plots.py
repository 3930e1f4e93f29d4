"""Plots of a study's own, of made-up points."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from sim.dataset.build import build
from sim.dataset.results import COLUMNS, Results
from sim.figures.data import figure_data
from sim.parameters import ChuteParameters
from sim.parameters.laws import LAW
from sim.study.figure_spec import FigureSpec
from sim.study.load import load_study, parse_study
from tests.figures.drawing import picture, table
from tests.made.results import MadePoint, made_point, made_results
from tests.made.runs import write_run

GRID = {"friction": [0.3, 0.4, 0.6], "angle": [16, 17]}
SIZE, SPEED = ChuteParameters().diameter, ChuteParameters().velocity_unit


def made(plot: Mapping, points: Sequence[MadePoint]) -> tuple[FigureSpec, Results]:
    """Return a plot of points, and these as results."""
    names = (*GRID, "youngs_modulus") if points[0].parameters.law not in LAW.usual else GRID
    cases = [{name: getattr(one.parameters, name) for name in names} for one in points]
    base = {"law": points[0].parameters.law}
    series = {"name": "flows", "system": "chute", "base": base, "cases": cases}
    study = parse_study(
        {"study": "s", "series": [series], "plots": [{"name": "p"} | dict(plot)]}, "s.yaml", None
    )
    found = made_results(*points)
    names = ("point", np.full(len(points), "flows", object))
    systems = ("point", np.full(len(points), "chute", object))
    root = found.dataset.assign_coords(series=names, system=systems)
    return study.plots["p"], replace(
        found, dataset=root, boundaries=pd.DataFrame(columns=list(COLUMNS))
    )


def courses(folder: Path, option: str, velocity: Sequence[float]) -> tuple[Path, Path]:
    """Return study file and dataset of a plot of time series with an option, of made-up run files.

    Flows at two frictions, with a ``velocity`` of each replicate.
    """
    path = folder / "own.yaml"
    path.write_text(
        "study: own\nseries: [{name: flows, system: chute, base: {replicates: 2},\n"
        "  grid: {friction: [0.3, 0.4]}}]\n"
        f"plots: [{{name: courses, kind: time_series, curves: friction, {option}}}]\n"
    )
    for point in load_study(path, folder).points.values():
        write_run(folder / "own" / "runs", point.parameters, velocity=velocity)
    return path, build(path, folder)


def flows(**options) -> list[MadePoint]:
    """Return flows that are slower the rougher they are, in packing 0.6 up to 5 diameters."""

    def packing(height):
        return np.where(height < 5 * SIZE, 0.6, 0.0)

    def hot(height):
        return np.where(height < 5 * SIZE, 2.0 + 0 * height, np.nan)

    profiles = {
        "packing_profile": packing,
        "velocity_profile": lambda height: height / SIZE,
        "granular_temperature_profile": hot,
    }
    return [
        made_point(
            "chute",
            {"velocity": angle / 16 - friction, "shear_depth": 2 * SIZE},
            profiles,
            friction=friction,
            angle=angle,
            **options,
        )
        for friction in GRID["friction"]
        for angle in GRID["angle"]
    ]


def drawn(plot: Mapping, points: Sequence[MadePoint] | None = None):
    spec, results = made(plot, flows() if points is None else points)
    data = figure_data(results, spec)
    return picture(data), table(data), data
