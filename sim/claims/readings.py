"""Readings of the papers: the headline reading, the open choices and the controls."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sim.base.messages import input_error
from sim.base.yaml import read_yaml
from sim.dataset.results import Results
from sim.parameters import SYSTEMS, roles
from sim.parameters.laws import LAW
from sim.parameters.words import setting

_TABLE = "readings.yaml"

#: Label of the defaults of all readings.
DEFAULT = "default"

#: The reading that is no parameter of runs: the grid on which the same profiles are evaluated.
GRID = "profile_grid"


class Control(BaseModel):
    """Values of parameters that are no reading of the paper, and why."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    values: dict[str, Any] = Field(min_length=1)
    why: str = Field(min_length=1)


class Readings(BaseModel):
    """How one system's paper is read."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    headline: dict[str, Any] = Field(description="what differs from the defaults")
    why: str = Field(min_length=1, description="why it gives the verdicts")
    open: dict[str, str] = Field(description="by parameter, the words that leave it open")
    rows: dict[str, list[float]] = Field(
        {}, description="by parameter of the grid, values of base rows that are readings as well"
    )
    grids: dict[str, str] = Field(
        {}, description="by grid of the profiles other than the usual one, what it is"
    )
    model: list[dict[str, Any]] = Field(
        [{}], description="those under which claims on the model itself are judged"
    )
    controls: list[Control] = Field(description="what is no reading")

    def control_reason(self, reading: Mapping[str, Any]) -> str:
        """Return why a reading is not one of the paper's, empty where it is one."""
        if LAW.is_own(reading.get("law", "")):
            return "the law of a plug-in"
        for control in self.controls:
            if control.values.items() <= reading.items():
                return control.why
        return ""

    def sentences(self, reading: Mapping[str, Any]) -> list[str]:
        """Return the words of the paper that leave a reading open."""
        return [self.open[name] for name in reading if name in self.open]


#: Readings of a system without a paper.
_NO_PAPER = Readings(headline={}, why="no paper is read", open={}, controls=[])


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    chute: Readings
    belt: Readings


@cache
def readings_of(system: str) -> Readings:
    """Return how the paper of a system is read; a system without a paper has nothing open."""
    try:
        table = _Table.model_validate(read_yaml(Path(__file__).parent / _TABLE))
    except ValidationError as error:
        raise input_error(error, _Table, _TABLE) from None
    return getattr(table, system, None) or _NO_PAPER


def reading_label(system: str, reading: Mapping[str, Any]) -> str:
    """Return a reading in words, ``default`` for the defaults."""
    words = [
        readings_of(system).grids[value] if name == GRID else setting(system, name, value)
        for name, value in reading.items()
    ]
    return "; ".join(words) or DEFAULT


def readings_with_runs(results: Results, system: str) -> list[dict[str, Any]]:
    """Return the readings other than the default that some points of a system have.

    Choices of the models come first, then base rows: flows of another cell, or another stiffness.
    Last are other grids for the profiles of the default reading's runs.
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
        for name, values in readings_of(system).rows.items()
        for value in values
        if value in points[name].values
    ]
    return [*readings.values(), *rows, *({GRID: name} for name in readings_of(system).grids)]
