"""Readings of the papers: the headline reading, the open choices and the controls."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sim.dataset.results import Results
from sim.parameters import SYSTEMS, roles
from sim.parameters.words import setting
from sim.study.papers import Readings, papers

#: Label of the defaults of all readings.
DEFAULT = "default"

#: The reading that is no parameter of runs: the grid on which the same profiles are evaluated.
GRID = "profile_grid"


def readings_of(system: str, paper: str = "") -> Readings:
    """Return how a paper is read, for claims of no paper the first paper of their system."""
    every = papers()
    of_system = (one for one in every.values() if one.system == system)
    one = every.get(paper) or next(of_system, None)
    return one.readings if one else Readings()


def reading_label(system: str, reading: Mapping[str, Any], readings: Readings) -> str:
    """Return one of the readings of a paper in words, ``default`` for the defaults."""
    words = [
        readings.grids[value] if name == GRID else setting(system, name, value)
        for name, value in reading.items()
    ]
    return "; ".join(words) or DEFAULT


def is_regridded(reading: Mapping[str, Any], headline: Mapping[str, Any]) -> bool:
    """True for runs of another reading than the headline one, evaluated on another grid."""
    return GRID in reading and reading != {**headline, GRID: reading[GRID]}


def combined_readings(results: Results, system: str, readings: Readings) -> list[dict[str, Any]]:
    """Return the readings under which runs of a system can be judged.

    The headline reading is first, or the default where no run has it. What the paper's words allow
    together is judged together: the runs of each reading, evaluated on each grid of the profiles.
    """
    runs = [{}, *_readings_with_runs(results, system, readings)]
    first = readings.headline if readings.headline in runs else {}
    ordered = [first, *(one for one in runs if one != first)]
    grids = [{}, *({GRID: name} for name in readings.grids)]
    return [one | grid for one in ordered for grid in grids]


def model_readings(
    results: Results, system: str, readings: Readings
) -> Sequence[Mapping[str, Any]]:
    """Return the readings at which experiments on the model are made.

    The engine is compiled for each, which takes long: a study that has runs of none has the default
    alone.
    """
    names = {name for changes in readings.model for name in changes}
    has_runs = any(names & one.keys() for one in _readings_with_runs(results, system, readings))
    return readings.model if has_runs else [{}]


def _readings_with_runs(
    results: Results, system: str, paper_readings: Readings
) -> list[dict[str, Any]]:
    """Return the readings other than the default that some points of a system have.

    Choices of the models come first, then base rows: flows of another cell, or another stiffness.
    """
    model = SYSTEMS[system]
    defaults = model()
    points = results.dataset.isel(point=np.flatnonzero(results.dataset["system"] == system))
    columns = {name: points[name].values.tolist() for name in roles.reading_parameters(model)}
    readings = {}
    for values in zip(*columns.values(), strict=True):
        pairs = zip(columns, values, strict=True)
        unusual = {name: value for name, value in pairs if value != getattr(defaults, name)}
        if unusual:
            readings[tuple(unusual.items())] = unusual
    rows = [
        {name: value}
        for name, values in paper_readings.rows.items()
        for value in values
        if value in points[name].values
    ]
    return [*readings.values(), *rows]
