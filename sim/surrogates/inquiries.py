"""Answers of sensitivities and calibrations, from surrogates and runs to files."""

from pathlib import Path

import numpy as np
import pandas as pd

from sim.dataset.results import Results
from sim.parameters import point_id
from sim.study.calibration import CalibrationSpec
from sim.study.sensitivity import SensitivitySpec
from sim.surrogates import calibration, tables
from sim.surrogates.indices import (
    morris_indices_of_runs,
    sobol_indices,
    sobol_indices_of_runs,
)
from sim.surrogates.posterior import Calibration, calibrate
from sim.surrogates.sample import points_of_mean, sample_points
from sim.surrogates.storage import load


def answer_sensitivity(spec: SensitivitySpec, dataset: Results, folder: Path) -> None:
    """Write the table of indices of a sensitivity into a folder of results."""
    if spec.design is None:
        table = sobol_indices(load(folder / spec.of.file))
    else:
        table = _indices_of_runs(spec, dataset)
    tables.save(table, folder / spec.file)


def _indices_of_runs(spec: SensitivitySpec, dataset: Results) -> pd.DataFrame:
    """Return the indices of the runs of a design, taken in the order of the design."""
    assert spec.design, "a surrogate has none"
    sample = sample_points(dataset, spec.of)
    counts = points_of_mean(sample, spec.of.regimes)
    means = pd.Series(np.where(counts, sample["mean"].values, np.nan), sample["point"].values)
    errors = pd.Series(sample["standard_error"].values, sample["point"].values)
    # Points of a design that are equal are one point of the study.
    ids = [point_id(point) for point in spec.design.points(spec.design.size)]
    values = means.reindex(ids).to_numpy(), errors.reindex(ids).to_numpy()
    source = f"sensitivity {spec.name}"
    if spec.is_screening:
        shares = spec.design.shares(spec.design.size)
        return morris_indices_of_runs(spec.design.names, shares, *values, source)
    return sobol_indices_of_runs(spec.design.names, *values, source)


def answer_calibration(spec: CalibrationSpec, folder: Path) -> None:
    """Write the posterior of a calibration into a folder of results."""
    question = Calibration(
        predictor=load(folder / spec.of.file),
        ranges=spec.ranges,
        conditions={name: np.array(one) for name, one in spec.conditions.items()},
        values=np.array(spec.values),
        errors=np.array(spec.errors),
        observable=spec.of.observable,
    )
    calibration.save(spec.name, calibrate(question), folder / spec.file)
