"""Rounds of further points: those that boundaries and surrogates ask for, given all runs so far."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.base.seals import to_sealed_json
from sim.dataset.boundaries import added_points
from sim.dataset.rounds import read_round
from sim.parameters import Parameters, canonical_values
from sim.study.load import Study, load_study
from sim.study.points import estimate
from sim.study.surrogate import SurrogateFile


def write_round(study_path: str | Path, number: int, results: str | Path = "results") -> Path:
    """Write the points that a round adds to ``results/<study>/rounds/<number>.json``.

    Parameters
    ----------
    study_path : str or Path
        The study file.
    number : int
        Number of the round, from 1; the runs and the files of all rounds before it must be there.
    results : str or Path
        Folder of all results.

    Returns
    -------
    Path
        The file written: parameters by id of the point, none where the rounds have ended, and a
        checksum. It appears complete or not at all.

    Raises
    ------
    InputError
        When the study has no such round, or a run file is missing or is not one.
    """
    study = load_study(study_path, results)
    if not 1 <= number <= study.rounds:
        allowed = f"a round of the study, 1 to {study.rounds}" if study.rounds else "none"
        raise InputError.of_value("ROUND", "", number, allowed)
    folder = Path(results) / study.name
    points = round_points(study, number, folder)
    output = folder / "rounds" / f"{number}.json"
    output.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(output) as temporary:
        values = {key: canonical_values(point) for key, point in points.items()}
        temporary.write_text(to_sealed_json(values), encoding="utf-8")
    return output


def round_points(study: Study, number: int, folder: Path) -> dict[str, Parameters]:
    """Return the points by id that a round adds to all before it.

    They depend only on the runs of the points before it, so every call gives the same points.
    """
    searched = max((boundary.rounds for boundary in study.boundaries), default=0)
    points = added_points(study, number, folder / "runs") if number <= searched else {}
    asking = [one for one in study.surrogates if one.has_rounds]
    if not asking:
        return points
    so_far = {key: point.parameters for key, point in study.points.items()}
    for earlier in range(1, number):
        so_far |= read_round(folder / "rounds" / f"{earlier}.json")
    for one in asking:
        points |= further_points(study, one, so_far, folder)
    return {key: point for key, point in points.items() if key not in so_far}


def further_points(
    study: Study, spec: SurrogateFile, so_far: Mapping[str, Parameters], folder: Path
) -> dict[str, Parameters]:
    """Return the next points of a surrogate's design, none where its error or budget is reached.

    Parameters
    ----------
    study : Study
        The study.
    spec : SurrogateFile
        The surrogate.
    so_far : mapping
        All points so far, by id; their runs must be there.
    folder : Path
        Results of the study.
    """
    # Imported here, as rounds of boundaries need none of it.
    from sim.dataset.build import gather_results
    from sim.surrogates.answers import Refusal
    from sim.surrogates.sample import sample_points
    from sim.surrogates.surrogate import Surrogate

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
