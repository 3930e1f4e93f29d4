"""Answer the questions of a study from its dataset, and write the answers."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import percent
from sim.dataset.replicates import replicate_values
from sim.dataset.results import Results, load_results
from sim.parameters import point_id
from sim.study.calibration import CalibrateFile
from sim.study.design_file import DesignFile
from sim.study.load import load_study
from sim.study.plottable import numbers
from sim.study.surrogate import LARGE_ERROR, Question, SensitivityFile, SurrogateFile
from sim.surrogates import answers, storage
from sim.surrogates.answers import (
    Refusal,
    answer_name,
    caveats_of_indices,
    caveats_of_points,
    save_refusal,
    summary_lines,
    with_caveats,
)
from sim.surrogates.indices import (
    DesignRuns,
    indices_of_surrogate,
    morris_indices_of_runs,
    sobol_indices_of_runs,
)
from sim.surrogates.likelihood import Calibration
from sim.surrogates.posterior import calibrate
from sim.surrogates.predictor import unscaled
from sim.surrogates.sample import points_of_mean, sample_points
from sim.surrogates.storage import load_surrogate, save_surrogate
from sim.surrogates.surrogate import Surrogate

#: Most draws of a posterior that are compared with the places of runs.
_MOST_DRAWS = 200


def build(study_path: str | Path, results: str | Path = "results") -> list[str]:
    """Write the file of each question of a study, in ``results/<study>/``.

    ``surrogates/<name>.nc``, ``sensitivity/<name>.csv``, ``calibration/<name>.nc``. Where the runs
    cannot answer a question, its file says why.

    Returns
    -------
    list of str
        Lines with the answers in short.

    Raises
    ------
    InputError
        When the dataset is missing or damaged.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    dataset = load_results(folder / "dataset.nc")
    for question in study.questions:
        path = folder / question.file
        try:
            answer(question, dataset, folder)
        except Refusal as refusal:
            save_refusal(Refusal(f"{answer_name(path)}: {refusal}"), path)
        except (ValueError, ArithmeticError) as error:
            # A fit that fails takes no other answer with it.
            reason = f"{question.file}: no answer, as its values cannot be fitted: {error}"
            save_refusal(Refusal(reason), path)
    return summary_lines(study, folder)


def answer(spec: Question, dataset: Results, folder: Path) -> None:
    """Write the answer to a question into a folder of results.

    Surrogates come first, as the other questions are asked of them.

    Raises
    ------
    Refusal
        When the runs cannot answer it.
    """
    match spec:
        case SurrogateFile():
            save_surrogate(Surrogate.fit(spec, sample_points(dataset, spec)), folder / spec.file)
        case SensitivityFile():
            _answer_sensitivity(spec, dataset, folder)
        case CalibrateFile():
            _answer_calibration(spec, folder)


def _surrogate_of(spec: SensitivityFile | CalibrateFile, lack: str, folder: Path) -> Surrogate:
    """Return the surrogate that a question is asked of; a refusal says what the question lacks."""
    try:
        surrogate = load_surrogate(folder / spec.of.file)
    except Refusal as refusal:
        raise Refusal(f"{lack} without its surrogate; {refusal}") from None
    require_small_error(surrogate, spec.surrogate_error, lack)
    return surrogate


def _answer_sensitivity(spec: SensitivityFile, dataset: Results, folder: Path) -> None:
    if spec.design is None:
        surrogate = _surrogate_of(spec, "no indices", folder)
        table, caveats = indices_of_surrogate(surrogate), surrogate.caveats
    else:
        sample = sample_points(dataset, spec.of)
        is_used = points_of_mean(sample, spec.of.mean_regimes)
        table, caveats = (
            _indices_of_runs(spec, dataset, sample, is_used),
            caveats_of_points(sample.isel(point=is_used)),
        )
    caveats = *caveats, *caveats_of_indices(table)
    answers.save_table(with_caveats(table, caveats), folder / spec.file)


def _indices_of_runs(
    spec: SensitivityFile, dataset: Results, sample: xr.Dataset, is_used: np.ndarray
) -> pd.DataFrame:
    """Return the indices of the runs of a design, taken in the order of the design."""
    assert spec.design, "a surrogate has none"
    design = spec.design
    means = pd.Series(np.where(is_used, sample["mean"].values, np.nan), sample["point"].values)
    # Points of a design that are equal are one point of the study.
    ids = [point_id(point) for point in design.sequence(design.size)]
    observable = numbers(spec.of.system)[spec.of.observable]
    beds = replicate_values(dataset, observable, list(means.index))
    scatter = [row.var(ddof=1) / row.size if row.size > 1 else np.nan for row in beds]
    runs = DesignRuns(
        names=design.names,
        values=means.reindex(ids).to_numpy(),
        variances=pd.Series(scatter, means.index).reindex(ids).to_numpy(),
        points=pd.factorize(np.array(ids))[0],
    )
    if spec.is_screening:
        is_number = [axis.is_number for axis in design.axes]
        return morris_indices_of_runs(
            runs, design.shares(design.size), places_of(design), is_number
        )
    return sobol_indices_of_runs(runs)


def places_of(design: DesignFile) -> np.ndarray:
    """Return the values that a design runs as shares of the ranges of its axes, (n, k).

    These are not the shares that it asks for: values are rounded, those of integers to integers.
    """
    rows = design.rows(design.size)
    columns = [
        [row[axis.name] if axis.is_number else axis.choices.index(row[axis.name]) for row in rows]
        for axis in design.axes
    ]
    bounds = np.array([(axis.low, axis.high) for axis in design.axes])
    return unscaled(np.column_stack(columns), bounds, [axis.scale for axis in design.axes])


def _answer_calibration(spec: CalibrateFile, folder: Path) -> None:
    surrogate = _surrogate_of(spec, "no posterior", folder)
    question = Calibration(
        predictor=surrogate,
        ranges=spec.ranges,
        conditions={name: np.array(one) for name, one in spec.conditions.items()},
        values=np.array(spec.values),
        errors=np.array(spec.errors),
        observable=spec.of.observable,
        has_discrepancy=spec.discrepancy,
    )
    groups = calibrate(question)
    groups["observed_data"].attrs |= {
        "far": _far_share(question, groups, surrogate),
        "surrogate_error": surrogate.error,
        "surrogate_points": len(surrogate.process.y),
        "points": surrogate.sample.sizes["point"],
    }
    storage.save_posterior(spec.name, groups, surrogate.caveats, folder / spec.file)


def _far_share(
    question: Calibration, groups: Mapping[str, xr.Dataset], surrogate: Surrogate
) -> float:
    """Return the share of a posterior, under the conditions measured, that has no run near it."""
    if "posterior" not in groups:
        return 0.0
    draws = np.column_stack([groups["posterior"][name].values.ravel() for name in question.names])
    draws = draws[:: max(1, len(draws) // _MOST_DRAWS)]
    shares = unscaled(draws, question.bounds, question.scales)
    x = question.points(shares, question.conditions)
    return float(surrogate.is_far(x.reshape(-1, x.shape[2])).mean())


def require_small_error(surrogate: Surrogate, most: float | None, lack: str) -> None:
    """Refuse a question to a surrogate whose error is too large; ``lack`` is what is missing."""
    most = most or LARGE_ERROR
    if surrogate.error > most:
        raise Refusal(
            f"{lack}, as the error of surrogate {surrogate.name} is above {percent(most)} "
            f"({surrogate.basis}); more points or longer runs lessen it, or a larger "
            "surrogate_error accepts it"
        )
