"""Made-up answers to questions of a study, as files, and the data of their pictures."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd

from sim.figures.data import FigureData
from sim.study.figure_spec import Answer, FigureSpec
from sim.surrogates import storage
from sim.surrogates.indices import sobol_indices, tabulate
from sim.surrogates.posterior import calibrate
from tests.surrogates.predictors import SLOPE, made_measurements

#: Sobol' indices of the made-up slope, and its parameters as the chute has them.
BLOCKS = 2**6


def picture_data(folder: Path, kind: str, answer: str) -> FigureData:
    """Return the data of a picture of an answer in a folder of results."""
    of = Answer(answer, unit="m s-1")
    spec = FigureSpec.model_construct(name="made", kind=kind, system="chute", answer=of)
    results = SimpleNamespace(runs=folder / "runs")
    return FigureData(spec, pd.DataFrame(), pd.DataFrame(), results)  # type: ignore[arg-type]


def write_indices(folder: Path, error: float = 0.05) -> str:
    """Write the indices of the made-up slope; return their path in the folder."""
    table = sobol_indices(replace(SLOPE, error=error), BLOCKS).assign(error=error)
    table.to_csv(folder / "indices.csv", index=False)
    return "indices.csv"


def write_effects(folder: Path, left_out: int = 2, noise: float = 0.1) -> str:
    """Write effects of a screening; return their path in the folder."""
    names = [(index, name, "") for index in ("mu", "mu_star", "sigma") for name in SLOPE.parameters]
    values = np.array([1.0, -0.5, 0.0, 1.0, 0.5, 0.05, 0.3, 0.3, 0.3])
    ends = values - 0.1, values + 0.1
    table = tabulate(names, values, *ends, blocks=10, left_out=left_out, noise=noise)
    table.to_csv(folder / "effects.csv", index=False)
    return "effects.csv"


def write_calibration(folder: Path, shift: float = 0.0) -> str:
    """Write a calibration of made-up measurements; return its path in the folder."""
    _, made = made_measurements(1, shift)
    storage.save_posterior("made", calibrate(made), [], folder / "calibration.nc")
    return "calibration.nc"
