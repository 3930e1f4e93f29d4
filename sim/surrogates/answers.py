"""Answer the questions of a study from its dataset, and write the answers."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from sim.base.files import atomic_write
from sim.dataset.results import Results, load_results
from sim.parameters import point_id
from sim.study.calibration import CalibrationSpec
from sim.study.load import load_study
from sim.study.sensitivity import SensitivitySpec
from sim.surrogates import calibration
from sim.surrogates.indices import (
    morris_indices_of_runs,
    sobol_indices,
    sobol_indices_of_runs,
)
from sim.surrogates.posterior import Calibration, calibrate
from sim.surrogates.sample import sample_points
from sim.surrogates.storage import load, save, summary_line
from sim.surrogates.surrogate import fit_surrogate, included


def build(study_path: str | Path, results: str | Path = "results") -> list[str]:
    """Write the file of each question of a study, in ``results/<study>/``.

    ``surrogates/<name>.nc``, ``sensitivity/<name>.csv``, ``calibration/<name>.nc``.

    Returns
    -------
    list of str
        Lines with the answers in short.

    Raises
    ------
    InputError
        When the dataset is missing, or has too few points for an answer.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    dataset = load_results(folder / "dataset.nc")
    lines: list[str] = []
    for surrogate in study.surrogates:
        path = folder / surrogate.file
        save(fit_surrogate(surrogate, sample_points(dataset, surrogate)), path)
        lines.append(summary_line(path))
    for sensitivity in study.sensitivities:
        lines += _answer_sensitivity(sensitivity, dataset, folder)
    for one in study.calibrations:
        lines += _answer_calibration(one, folder)
    return lines


def _answer_sensitivity(spec: SensitivitySpec, dataset: Results, folder: Path) -> Iterator[str]:
    """Write the indices of a sensitivity; yield what matters most, in a line."""
    path = folder / spec.file
    if spec.design is None:
        table = sobol_indices(load(folder / spec.of.file))
    else:
        table = _indices_of_runs(spec, dataset)
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format="%.10g")
    rows = table[table["index"] == ("mu_star" if spec.is_screening else "total")]
    rows = rows.sort_values("value", ascending=False)
    values = ", ".join(f"{row.parameter} {row.value:.2g}" for row in rows.itertuples())
    yield f"sensitivity {spec.name}: {values}"


def _indices_of_runs(spec: SensitivitySpec, dataset: Results) -> pd.DataFrame:
    """Return the indices of the runs of a design, in the order of which they stand."""
    assert spec.design, "a surrogate has none"
    sample = sample_points(dataset, spec.of)
    counts = included(sample, spec.of.regimes)
    means = pd.Series(np.where(counts, sample["mean"].values, np.nan), sample["point"].values)
    errors = pd.Series(sample["standard_error"].values, sample["point"].values)
    ids = [point_id(point) for point in spec.design.points(spec.design.size)]
    values = means.reindex(ids).to_numpy(), errors.reindex(ids).to_numpy()
    source = f"sensitivity {spec.name}"
    if spec.is_screening:
        shares = spec.design.shares(spec.design.size)
        return morris_indices_of_runs(spec.design.names, shares, *values, source)
    return sobol_indices_of_runs(spec.design.names, *values, source)


def _answer_calibration(spec: CalibrationSpec, folder: Path) -> Iterator[str]:
    """Write the posterior of a calibration; yield what it says, line by line."""
    question = Calibration(
        predictor=load(folder / spec.of.file),
        ranges=spec.ranges,
        conditions={name: np.array(one) for name, one in spec.conditions.items()},
        values=np.array(spec.values),
        errors=np.array(spec.errors),
        observable=spec.of.observable,
    )
    groups = calibrate(question)
    calibration.save(groups, folder / spec.file)
    for sentence in calibration.outcome_sentences(groups):
        yield f"calibration {spec.name}: {sentence}"
