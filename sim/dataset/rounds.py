"""Rounds of refinement that have finished, and the sides of a boundary that runs are on."""

import json
from collections.abc import Collection
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import cast

import numpy as np

from sim.base.errors import InputError
from sim.base.seals import CHECKSUM, checked_read, parse_sealed_json
from sim.engine.stored_run import NamedValues, read_parameters, summary_of
from sim.parameters import (
    RUN_FILE,
    BeltParameters,
    ConveyorParameters,
    Parameters,
    amounts,
    parse_point,
    point_id,
    require_compatible_source,
)
from sim.parameters.belt import ONSET_TRANSPORT
from sim.study.expand import point_with_membership
from sim.study.model import Study

#: Columns of the table of boundaries that hold results.
RESULT_COLUMNS = ("low", "high", "below", "above", "verdict", "points")

#: Systems that can have a boundary of ``transport``.
VibratedParameters = BeltParameters | ConveyorParameters

#: Regimes on each side of a boundary, for each kind of boundary that regimes decide.
REGIMES = {
    "flow": {"arrested": ["arrested"], "flowing": ["steady", "accelerating"]},
    "acceleration": {"not accelerating": ["arrested", "steady"], "accelerating": ["accelerating"]},
}

#: The scalars of a run that decide its side.
SCALARS = (
    "status",
    "regime",
    "velocity",
    "velocity_half_width",
    "acceleration",
    "acceleration_half_width",
)


def read_round(path: Path) -> dict[str, Parameters]:
    """Read the points by id that a round has added; a damaged file is set aside.

    Raises `InputError` when there is no such file, or it is not a round.
    """
    with checked_read(path, "round of refinement", replaceable=True):
        text = path.read_text(encoding="utf-8")
        mappings = json.loads(text)
        # A file of an earlier version has no checksum.
        if CHECKSUM in mappings:
            mappings = parse_sealed_json(text)
        try:
            points = {key: parse_point(values, path) for key, values in mappings.items()}
        except InputError as error:
            raise ValueError(error) from None
        wrong = [key for key, point in points.items() if key != point_id(point)]
        if wrong:
            raise ValueError(f"{wrong[0]} is not the id of its point")
        return points


def round_files(study: Study, folder: Path) -> list[Path]:
    """Return the files of the finished rounds, given the results folder of the study.

    A round that adds no point is the last one.
    """
    files: list[Path] = []
    for number in range(1, study.rounds + 1):
        path = folder / "rounds" / f"{number}.json"
        if not path.is_file():
            break
        files.append(path)
        if not read_round(path):
            break
    return files


def rounds_to_come(study: Study, folder: Path) -> int:
    """Return how many rounds are to come at least: one, where their number is open."""
    files = round_files(study, folder)
    if files and not read_round(files[-1]):
        return 0
    left = study.rounds - len(files)
    return min(left, 1) if any(one.has_rounds for one in study.surrogates) else left


def points_of_rounds(study: Study, folder: Path) -> dict[str, Parameters]:
    """Return the points of the study file and those that its finished rounds have added."""
    points = {key: point.parameters for key, point in study.points.items()}
    for path in round_files(study, folder):
        points |= read_round(path)
    return points


def add_further_points(study: Study, known: Collection[str]) -> Study:
    """Return the study with the points that rounds have added to the series of its surrogates.

    ``known`` are the ids of all points, those of rounds included.
    """
    points, series = dict(study.points), dict(study.series)
    for one in study.surrogates if len(known) > len(points) else ():
        if not one.has_rounds:
            continue
        for key, parameters in one.added_points(known).items():
            points[key] = point_with_membership(points, parameters, one.series, one.figures)
            series[one.series] = tuple(dict.fromkeys((*series[one.series], key)))
    return replace(study, points=points, series=series)


def require_start_files(study: Study) -> None:
    """Refuse a run file that a point of a study cannot start from.

    Points that start from other points of the study were checked when the study was loaded. Raises
    `InputError` when it is damaged or no run file, or a flow of the point cannot go on from its
    flow.
    """

    read = cache(read_parameters)
    for point in study.points.values():
        if (start := point.parameters.start_from).endswith(RUN_FILE):
            try:
                source = read(Path(start))
            except InputError as error:
                raise InputError(f"{study.path}: start_from: {error}") from None
            require_compatible_source(point.parameters, source, str(study.path))


def side_of_run(path: Path, of: str, parameters: Parameters) -> str | None:
    """Return the side that the run in a file is on, see `side`.

    Raises `InputError` when there is no such file, or it is not a run file of this point.
    """
    with checked_read(path, "run file", replaceable=True, sealed=True):
        run = summary_of(path, amounts(parameters))
        if run.attrs["point_id"] != point_id(parameters):
            raise ValueError(f"holds point {run.attrs['point_id']}")
        return side(run.scalars, of, parameters)


def side(scalars: NamedValues, of: str, parameters: Parameters) -> str | None:
    """Return the side that a run is on, ``None`` where it is undecided.

    Failed replicates are left out; the others must agree. A flow of undetermined regime counts as
    flowing if the whole 95 % interval of its velocity is above zero and that of its acceleration is
    not wholly below zero. ``scalars`` are the `SCALARS` of the run, each over its replicates;
    ``of`` is what changes at the boundary: ``flow``, ``acceleration`` or ``transport``.
    """
    values = {name: np.asarray(scalars[name]) for name in SCALARS}
    velocity, margin, regime = (
        values[name] for name in ("velocity", "velocity_half_width", "regime")
    )
    slowest, fastest = velocity - margin, velocity + margin
    if of == "transport":
        # Only vibrated systems can have this boundary in a study.
        least = ONSET_TRANSPORT * cast(VibratedParameters, parameters).velocity_amplitude
        where = {"no transport": fastest <= least, "transport": slowest > least}
    else:
        where = {side: np.isin(regime, regimes) for side, regimes in REGIMES[of].items()}
    if of == "flow":
        gain = values["acceleration"] + values["acceleration_half_width"]
        where["flowing"] |= (regime == "undetermined") & (slowest > 0) & (gain >= 0)
    completed = values["status"] == "completed"
    sides = [side for side, is_there in where.items() if is_there[completed].all()]
    return sides[0] if completed.any() and sides else None
