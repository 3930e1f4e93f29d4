"""Plots of a study's own, of made-up points."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd

from sim.dataset.results import COLUMNS, Results
from sim.figures.data import figure_data
from sim.parameters import ChuteParameters
from sim.parameters.laws import LAW
from sim.study.figure_spec import FigureSpec
from sim.study.load import parse_study
from tests.figures.drawing import picture, table
from tests.made.results import MadePoint, made_point, made_results

GRID = {"friction": [0.3, 0.4, 0.6], "angle": [16, 17]}
SIZE, SPEED = ChuteParameters().diameter, ChuteParameters().velocity_unit


def made(plot: Mapping, points: Sequence[MadePoint]) -> tuple[FigureSpec, Results]:
    """Return a plot of points, and these as results."""
    names = (*GRID, "grain_modulus") if points[0].parameters.law not in LAW.usual else GRID
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


def flows(**options) -> list[MadePoint]:
    """Return flows that are slower the rougher they are, in packing 0.6 up to 5 diameters."""

    profiles = {
        "packing_profile": lambda height: np.where(height < 5 * SIZE, 0.6, 0.0),
        "velocity_profile": lambda height: height / SIZE,
        "granular_temperature_profile": lambda height: np.where(height < 5 * SIZE, 2.0, np.nan),
    }
    scalars = {"shear_depth": 2 * SIZE}
    return [
        made_point(
            "chute", scalars | {"velocity": y / 16 - x}, profiles, friction=x, angle=y, **options
        )
        for x, y in product(*GRID.values())
    ]


def drawn(plot: Mapping, points: Sequence[MadePoint] | None = None):
    spec, results = made(plot, flows() if points is None else points)
    data = figure_data(results, spec)
    return picture(data), table(data), data
