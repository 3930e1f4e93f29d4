"""Answer the questions of a study from its dataset, and ask for the further points they need.

Rounds of further points are those that boundaries and surrogates ask for, given all runs so far.
"""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError, percent
from sim.base.files import atomic_write
from sim.base.seals import to_sealed_json
from sim.dataset.boundaries import added_points
from sim.dataset.build import gather_results
from sim.dataset.replicates import replicate_values
from sim.dataset.results import Results, load_results
from sim.dataset.rounds import read_round
from sim.parameters import Parameters, canonical_values, point_id
from sim.study.design_file import DesignFile
from sim.study.load import Study, load_study
from sim.study.model import estimate
from sim.study.plottable import numbers
from sim.study.questions import CalibrateFile, PropagationFile, SensitivityFile
from sim.study.surrogate import LARGE_ERROR, Question, SurrogateFile
from sim.surrogates import answers
from sim.surrogates.answers import Refusal, answer_name, save_refusal
from sim.surrogates.indices import (
    DesignRuns,
    indices_of_surrogate,
    morris_indices_of_runs,
    sobol_indices_of_runs,
)
from sim.surrogates.likelihood import Calibration
from sim.surrogates.posterior import calibrate
from sim.surrogates.propagation import spread_of_runs, spread_of_surrogate
from sim.surrogates.sample import points_of_mean, sample_points, unscaled
from sim.surrogates.storage import load_surrogate, save_posterior, save_surrogate, summary_lines
from sim.surrogates.surrogate import Surrogate

#: Most draws of a posterior that are compared with the places of runs.
_MOST_DRAWS = 200


def build(study_path: str | Path, results: str | Path = "results") -> list[str]:
    """Write the file of each question of a study, in ``results/<study>/``; return a line of each.

    Names of the files are those of `sim.study.surrogate.Question.file`. Where the runs cannot
    answer a question, its file says why. Surrogates come first, as the other questions are
    asked of them.

    Raises `InputError` when the dataset is missing or damaged.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    dataset = load_results(folder / "dataset.nc")
    for question in study.questions:
        path = folder / question.file
        try:
            _answer(question, dataset, folder)
        except Refusal as refusal:
            save_refusal(Refusal(f"{answer_name(path)}: {refusal}"), path)
        except (ValueError, ArithmeticError) as error:
            # A fit that fails takes no other answer with it.
            reason = f"{question.file}: no answer, as its values cannot be fitted: {error}"
            save_refusal(Refusal(reason), path)
    return summary_lines(study, folder)


def _answer(spec: Question, dataset: Results, folder: Path) -> None:
    """Write the answer to a question; raise `Refusal` when the runs cannot answer it."""
    match spec:
        case SurrogateFile():
            surrogate = Surrogate.fit(spec, sample_points(dataset, spec))
            save_surrogate(surrogate, folder / spec.file)
        case SensitivityFile() | PropagationFile():
            if spec.design is None:
                table, caveats = _table_of_surrogate(spec, folder)
            else:
                runs, caveats = _design_runs(spec, dataset)
                table = _table_of_runs(spec, runs)
            caveats = *caveats, *answers.caveats_of_indices(table)
            answers.save_table(answers.with_caveats(table, caveats), folder / spec.file)
        case CalibrateFile():
            surrogate = _surrogate_of(spec, "no posterior", folder)
            groups = _posterior(spec, surrogate)
            save_posterior(spec.name, groups, surrogate.caveats, folder / spec.file)


def _table_of_surrogate(
    spec: SensitivityFile | PropagationFile, folder: Path
) -> tuple[pd.DataFrame, tuple[str, ...]]:
    if isinstance(spec, SensitivityFile):
        surrogate = _surrogate_of(spec, "no indices", folder)
        return indices_of_surrogate(surrogate), surrogate.caveats
    surrogate, asked = _surrogate_of(spec, "no spread", folder), (spec.quantiles, spec.exceeds)
    return spread_of_surrogate(surrogate, spec.axes, spec.where, *asked), surrogate.caveats


def _surrogate_of(
    spec: SensitivityFile | PropagationFile | CalibrateFile, lack: str, folder: Path
) -> Surrogate:
    """Return the surrogate that a question is asked of; a refusal says what the question lacks."""
    try:
        surrogate = load_surrogate(folder / spec.of.file)
    except Refusal as refusal:
        raise Refusal(f"{lack} without its surrogate; {refusal}") from None
    require_small_error(surrogate, spec.surrogate_error, lack)
    return surrogate


def require_small_error(surrogate: Surrogate, most: float | None, lack: str) -> None:
    """Refuse a question to a surrogate whose error is too large; ``lack`` is what is missing."""
    most = most or LARGE_ERROR
    if surrogate.error > most:
        raise Refusal(
            f"{lack}, as the error of surrogate {surrogate.name} is above {percent(most)} "
            f"({surrogate.basis}); more points or longer runs lessen it, or a larger "
            "surrogate_error accepts it"
        )


def _design_runs(
    spec: SensitivityFile | PropagationFile, dataset: Results
) -> tuple[DesignRuns, tuple[str, ...]]:
    """Return the runs of a design, in its order, and caveats of these."""
    assert spec.design, "a surrogate has none"
    design, sample = spec.design, sample_points(dataset, spec.of)
    is_used = points_of_mean(sample, spec.of.mean_regimes)
    means = pd.Series(np.where(is_used, sample["mean"].values, np.nan), sample["point"].values)
    # Points of a design that are equal are one point of the study.
    ids = [point_id(point) for point in design.sequence(design.size)]
    observable = numbers(spec.of.system)[spec.of.observable]
    beds = replicate_values(dataset, observable, list(means.index))
    # Known to have no scatter although no point has a second replicate: a function without chance.
    is_exact = not sample.attrs["scatter"] and bool((sample["replicates"] <= 1).all())
    alone = 0.0 if is_exact else np.nan
    scatter = [row.var(ddof=1) / row.size if row.size > 1 else alone for row in beds]
    runs = DesignRuns(
        names=design.names,
        values=means.reindex(ids).to_numpy(),
        variances=pd.Series(scatter, means.index).reindex(ids).to_numpy(),
        points=pd.factorize(np.array(ids))[0],
    )
    return runs, answers.caveats_of_points(sample.isel(point=is_used))


def _table_of_runs(spec: SensitivityFile | PropagationFile, runs: DesignRuns) -> pd.DataFrame:
    if isinstance(spec, PropagationFile):
        return spread_of_runs(runs, spec.quantiles, spec.exceeds)
    if not spec.is_screening:
        return sobol_indices_of_runs(runs)
    assert spec.design, "a surrogate has none"
    design = spec.design
    shares, is_number = design.shares(design.size), [axis.is_number for axis in design.axes]
    return morris_indices_of_runs(runs, shares, places_of(design), is_number)


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


def _posterior(spec: CalibrateFile, surrogate: Surrogate) -> dict[str, xr.Dataset]:
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
    return groups


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


def write_round(study_path: str | Path, number: int, results: str | Path = "results") -> Path:
    """Write the points that a round, from 1, adds to ``results/<study>/rounds/<number>.json``.

    The runs and the files of all rounds before it must be there. The file has parameters by id of
    the point, none where the rounds have ended, and a checksum. It appears complete or not at all.

    Raises `InputError` when the study has no such round, or a run file is missing or is not one.
    """
    study = load_study(study_path, results)
    if not 1 <= number <= study.rounds:
        allowed = f"a round of the study, 1 to {study.rounds}" if study.rounds else "none"
        raise InputError.of_value("ROUND", "", number, allowed)
    folder = Path(results) / study.name
    points = _round_points(study, number, folder)
    output = folder / "rounds" / f"{number}.json"
    output.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(output) as temporary:
        values = {key: canonical_values(point) for key, point in points.items()}
        temporary.write_text(to_sealed_json(values), encoding="utf-8")
    return output


def _round_points(study: Study, number: int, folder: Path) -> dict[str, Parameters]:
    """Return the points by id that a round adds to all before it.

    They depend only on the runs of the points before it, so every call gives the same points.
    """
    searched = max((boundary.rounds for boundary in study.boundaries), default=0)
    points = added_points(study, number, folder / "runs") if number <= searched else {}
    if not any(one.has_rounds for one in study.surrogates):
        return points
    so_far = {key: point.parameters for key, point in study.points.items()}
    for earlier in range(1, number):
        so_far |= read_round(folder / "rounds" / f"{earlier}.json")
    for one in study.surrogates:
        points |= _further_points(study, one, so_far, folder) if one.has_rounds else {}
    return {key: point for key, point in points.items() if key not in so_far}


def _further_points(
    study: Study, spec: SurrogateFile, so_far: Mapping[str, Parameters], folder: Path
) -> dict[str, Parameters]:
    """Return the next points of a surrogate's design, none where its error or budget is reached.

    ``so_far`` are all points by id; their runs must be in the results of the study.
    """
    first = {key: so_far[key] for key in study.series[spec.series]}
    added = spec.added_points(so_far)
    members = first | added
    try:
        sample = sample_points(gather_results(study, folder, spec.series, members), spec)
    except Refusal:
        return {}
    # Further points may be those that a mean lacks.
    with suppress(Refusal):
        if Surrogate.fit(spec, sample).error <= spec.error:
            return {}
    hours = sample["core_hours"].to_series()
    # The median, as the first run of all may have compiled the engine.
    ratios = [hours[key] / _hours(point) for key, point in members.items()]
    factor = float(np.median(ratios)) or 1.0
    hours_left = spec.budget - float(hours[list(added)].sum())
    batch = {}
    for key, point in spec.next_batch(so_far).items():
        hours_left -= factor * _hours(point)
        if hours_left < 0:
            break
        batch[key] = point
    return batch


def _hours(point: Parameters) -> float:
    return estimate(point).core_seconds / 3600
