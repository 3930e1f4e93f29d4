"""Entries under ``calibrate`` of a study file, and what a study knows of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator

from sim.parameters.common import TWO_NUMBERS, Real, broken_rule
from sim.study.entries import ALLOWED_NAME, NAME, Strict, optional
from sim.study.measured import ALLOWED_FILE, FILE
from sim.study.surrogate import ACCEPTED_ERROR, SurrogateSpec

#: Most measurements: each is predicted some 100,000 times.
MOST_MEASUREMENTS = 1000


class CalibrateFile(Strict):
    """Which parameters measurements allow, by a surrogate."""

    name: str = Field(
        pattern=NAME,
        max_length=40,
        description="name of the answer and of its file, unique among calibrations",
        json_schema_extra=ALLOWED_NAME,
    )
    data: str = Field(
        pattern=FILE,
        description="CSV file in the folder of the study file: a row for each measurement; columns "
        "for the observable, its error and the conditions",
        json_schema_extra={"allowed": ALLOWED_FILE},
    )
    surrogate: str = Field(description="surrogate that stands for the model")
    parameters: dict[str, Any] = Field(
        description="parameters looked for, each with its lowest and highest value; they are "
        "evenly spread there before anything is measured",
        min_length=1,
        json_schema_extra={"allowed": f"a mapping of parameters to {TWO_NUMBERS}"},
    )
    observable: str = optional("column of the observable (omitted: its name)")
    error: str = optional(
        "column of the standard error of each measurement (omitted: `<observable>_error`)"
    )
    units: dict[str, str] = Field(
        {}, description="units of columns whose headings have none, as `velocity: mm/s`"
    )
    discrepancy: bool = Field(
        True,
        description="whether the model itself may lack something; `false` gives narrower intervals",
    )
    surrogate_error: Real = optional(ACCEPTED_ERROR, gt=0, le=10)

    @model_validator(mode="after")
    def _require_ranges(self) -> Self:
        for name, ends in self.parameters.items():
            is_pair = isinstance(ends, list) and len(ends) == 2
            if not is_pair or not all(type(end) in (int, float) for end in ends):
                raise broken_rule(f"parameters.{name}", ends, TWO_NUMBERS)
            if not ends[0] < ends[1]:
                raise broken_rule(f"parameters.{name}", ends, TWO_NUMBERS)
        return self


@dataclass(frozen=True)
class CalibrationSpec:
    """A question of a study: which parameters its measurements allow.

    Attributes
    ----------
    name : str
        Its name.
    of : SurrogateSpec
        The surrogate.
    ranges : mapping
        Lowest and highest value of each parameter looked for.
    conditions : mapping
        Values of the other parameters of the surrogate at each measurement.
    values, errors : tuple of float
        The measurements and their standard errors, in the unit of the observable.
    path : Path
        File of the measurements.
    has_discrepancy : bool
        Whether the model may lack something.
    surrogate_error : float, optional
        Largest error of the surrogate with which there is an answer.
    """

    name: str
    of: SurrogateSpec
    ranges: Mapping[str, tuple[float, float]]
    conditions: Mapping[str, tuple[float, ...]]
    values: tuple[float, ...]
    errors: tuple[float, ...]
    path: Path
    has_discrepancy: bool = True
    surrogate_error: float | None = None

    @property
    def series(self) -> str:
        """Series whose runs answer it."""
        return self.of.series

    @property
    def file(self) -> str:
        """Path of its file in the results of the study."""
        return f"calibration/{self.name}.nc"

    @property
    def settings(self) -> tuple[Any, ...]:
        """What it depends on besides runs; rules rerun when this changes."""
        parts = tuple(self.ranges.items()), tuple(self.conditions.items())
        own = (self.name, *parts, self.values, self.errors, self.has_discrepancy)
        return (*own, self.surrogate_error, self.of.settings)
