"""Entries under ``surrogate`` of a study file, and what a study knows of its surrogates."""

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice, takewhile
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from sim.parameters import Parameters, point_id
from sim.parameters.common import TWO_NUMBERS, Real, broken_rule
from sim.study.design import Axis, Design
from sim.study.entries import ALLOWED_NAME, NAME, Strict, optional
from sim.study.measured import ALLOWED_FILE, FILE

#: Fewest points of which a mean can be, and fewest for each parameter.
_FEWEST_POINTS, _POINTS_PER_PARAMETER = 4, 3

#: Most points of a surrogate: the time of a fit grows with the cube of their number.
MOST_POINTS = 3000

#: Most rounds of a study: a budget ends them long before.
MOST_ROUNDS = 1000

#: Points of a design that are drawn at a time.
_CHUNK = 64

#: Error of a mean, relative to its size, from which on it is called too large to rely on.
LARGE_ERROR = 0.2

#: Meaning of the key of what is asked of a surrogate that accepts a larger one.
ACCEPTED_ERROR = (
    "largest error of the surrogate with which there is an answer, relative to the mean size of "
    f"the observable ({LARGE_ERROR:g})"
)

Regime = Literal["steady", "accelerating", "arrested", "mixed", "undetermined", "slowing"]

#: An undetermined flow that surely slows down: answers leave it out.
SLOWING: Regime = "slowing"

#: Regimes whose points count unless an entry names others: all but what surely changes or rests.
COUNTED: tuple[Regime, ...] = ("steady", "mixed", "undetermined")


def fewest_points(parameters: int) -> int:
    """Return the fewest points of which a mean over some parameters can be."""
    return max(_FEWEST_POINTS, _POINTS_PER_PARAMETER * parameters)


class SurrogateFile(Strict):
    """A surrogate: an observable anywhere between the points of a series, with its error."""

    name: str = Field(
        pattern=NAME,
        max_length=40,
        description="name of the surrogate and of its file, unique in the study",
        json_schema_extra=ALLOWED_NAME,
    )
    series: str = Field(description="series whose points it goes through")
    observable: str = Field("velocity", description="observable, any number of `plots`")
    regimes: list[Regime] = Field(
        list(COUNTED),
        min_length=1,
        description="regimes whose points the mean is of, undetermined ones with their interval "
        "(slowing: those of them that surely slow down); others count for the probabilities alone",
    )
    error: Real = optional(
        "error at which rounds of further points end, relative to the mean size of the observable; "
        "with budget, of a design that grows",
        gt=0,
        le=1,
    )
    budget: Real = optional("core hours that rounds may add, of processor time", gt=0, le=1e6)
    batch: int = Field(4, description="points that a round adds", ge=1, le=1000)

    @model_validator(mode="after")
    def _require_error_and_budget(self) -> Self:
        for key, other in (("error", "budget"), ("budget", "error")):
            if getattr(self, key) is None and getattr(self, other) is not None:
                raise broken_rule(key, None, f"a number, as {other} is given: rounds need both")
        return self


@dataclass(frozen=True)
class SurrogateSpec:
    """A surrogate of a study.

    Attributes
    ----------
    name, series, observable : str
        Its name, the series of its points, and what it is of.
    system : str
        System of the series.
    axes : tuple of Axis
        Parameters that the points vary.
    regimes : tuple of str
        Regimes whose points the mean is of.
    error, budget : float
        Error at which rounds end, and core hours that they may add; 0 without rounds.
    batch : int
        Points that a round adds.
    design : Design, optional
        Design of the series; its further points are those of rounds.
    figures : tuple of str
        Figures of papers that points of rounds feed.
    """

    name: str
    series: str
    observable: str
    system: str
    axes: tuple[Axis, ...]
    regimes: tuple[str, ...] = COUNTED
    error: float = 0.0
    budget: float = 0.0
    batch: int = 4
    design: Design | None = None
    figures: tuple[str, ...] = ()

    @property
    def has_rounds(self) -> bool:
        """Whether rounds add points."""
        return self.error > 0

    @property
    def file(self) -> str:
        """Path of its file in the results of the study."""
        return f"surrogates/{self.name}.nc"

    @property
    def settings(self) -> tuple[Any, ...]:
        """What it and its rounds depend on besides runs; rules rerun when this changes."""
        axes = [(axis.name, axis.low, axis.high, axis.scale, axis.choices) for axis in self.axes]
        rounds = (self.error, self.budget, self.batch)
        return (self.name, self.series, self.observable, axes, self.regimes, *rounds)

    def further_points(self) -> Iterator[tuple[str, Parameters]]:
        """Yield the points of the design beyond those of the study file, in order, with ids."""
        assert self.design, "only a design goes on"
        for start in range(0, MOST_POINTS, _CHUNK):
            for point in self.design.points(_CHUNK, after=self.design.size + start):
                yield point_id(point), point

    def added_points(self, so_far: Container[str]) -> dict[str, Parameters]:
        """Return the further points that rounds have added: those before the first new one."""
        return dict(takewhile(lambda pair: pair[0] in so_far, self.further_points()))

    def next_batch(self, so_far: Container[str]) -> dict[str, Parameters]:
        """Return the next further points that are new, as many as a round adds."""
        further = (pair for pair in self.further_points() if pair[0] not in so_far)
        return dict(islice(further, self.batch))


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


#: Fewest blocks, or trajectories of Morris, that give an answer.
FEWEST_BLOCKS = 8


class SensitivityFile(Strict):
    """What matters: indices of a surrogate, or of the runs of a design made for them."""

    name: str = Field(
        pattern=NAME,
        max_length=40,
        description="name of the answer and of its file, unique among sensitivities",
        json_schema_extra=ALLOWED_NAME,
    )
    surrogate: str = optional("surrogate whose observable is explained")
    series: str = optional(
        "in place of a surrogate: series whose design is of kind `saltelli` or `morris`"
    )
    observable: str = optional("of a series: observable, any number of `plots` (velocity)")
    regimes: list[Regime] = optional(
        "of a series: regimes whose points count (steady, mixed, undetermined); blocks with others "
        "are left out",
        min_length=1,
    )
    surrogate_error: Real = optional(f"of a surrogate: {ACCEPTED_ERROR}", gt=0, le=10)

    @model_validator(mode="after")
    def _require_one_source(self) -> Self:
        if self.surrogate is None and self.series is None:
            raise broken_rule("surrogate", None, "the name of a surrogate, or series: a series")
        for key in ("series", "observable", "regimes") if self.surrogate is not None else ():
            if (value := getattr(self, key)) is not None:
                raise broken_rule(key, value, "none with surrogate, which has its own")
        if self.surrogate is None and (value := self.surrogate_error) is not None:
            rule = "none with series, whose runs need no surrogate"
            raise broken_rule("surrogate_error", value, rule)
        return self


@dataclass(frozen=True)
class SensitivitySpec:
    """A question of a study: how much each parameter matters.

    Attributes
    ----------
    name : str
        Its name.
    of : SurrogateSpec
        The surrogate, or what a surrogate of the series would be of.
    design : Design, optional
        Design of the series whose runs are analysed; none for a surrogate.
    surrogate_error : float, optional
        Largest error of the surrogate with which there is an answer.
    """

    name: str
    of: SurrogateSpec
    design: Design | None = None
    surrogate_error: float | None = None

    @property
    def series(self) -> str:
        """Series whose runs answer it."""
        return self.of.series

    @property
    def file(self) -> str:
        """Path of its file in the results of the study."""
        return f"sensitivity/{self.name}.csv"

    @property
    def is_screening(self) -> bool:
        """Whether it is Morris' screening."""
        return self.design is not None and self.design.kind == "morris"

    @property
    def settings(self) -> tuple[Any, ...]:
        """What it depends on besides runs; rules rerun when this changes."""
        own = (self.design.kind, self.design.size, self.design.seed) if self.design else ()
        return (self.name, *own, self.surrogate_error, self.of.settings)
