"""Questions of a study: what all have in common, and entries under ``surrogate`` of its file."""

from collections.abc import Container, Iterator, Mapping
from functools import partial
from itertools import islice, takewhile
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, Self

from pydantic import Field

from sim.base.errors import Allowed, InputError
from sim.base.messages import one_of
from sim.parameters import NUMERICAL, Parameters, point_id
from sim.parameters.common import Real
from sim.parameters.observables import require_observables
from sim.study.design import Axis
from sim.study.entries import ALLOWED_NAME, NAME, Strict, optional
from sim.study.plottable import find_observable, numbers, require_stored

#: Most points of a surrogate: the time of a fit grows with the cube of their number. Most rounds of
#: a study: a budget ends them long before. Points of a design that are drawn at a time.
MOST_POINTS, MOST_ROUNDS, _CHUNK = 3000, 1000, 64

#: Error of a mean, relative to its size, from which on it is called too large to rely on; and
#: meaning of the key of what is asked of a surrogate that accepts a larger one.
LARGE_ERROR = 0.2
ACCEPTED_ERROR = (
    "largest error of the surrogate with which there is an answer, relative to the mean size of "
    f"the observable ({LARGE_ERROR:g})"
)

#: Regimes; an undetermined flow that surely slows down, which answers leave out; and those whose
#: points count unless an entry names others: all but what surely changes or rests.
Regime = Literal["steady", "accelerating", "arrested", "mixed", "undetermined", "slowing"]
SLOWING: Regime = "slowing"
COUNTED: tuple[Regime, ...] = ("steady", "mixed", "undetermined")


def fewest_points(parameters: int) -> int:
    """Return the fewest points of which a mean over some parameters can be."""
    return max(4, 3 * parameters)


class Place(NamedTuple):
    """Where a question stands: a study file, a key of it, and the series and boundaries there."""

    path: Path
    key: str
    families: Mapping[str, Any]

    def error(self, key: str, value: Any, allowed: str | Allowed) -> InputError:
        """Return the error of a key of the question."""
        return InputError.of_value(self.path, f"{self.key}.{key}", value, allowed)


class Question(Strict):
    """A question to the runs of a study, as its file has it; `resolve` adds what follows."""

    name: str

    #: What `resolve` adds: the surrogate that it is asked of, or what one of its series would be.
    of: ClassVar[Any]

    #: Folder of its answer in the results of a study, and ending of the file.
    folder: ClassVar[str]
    ending: ClassVar[str] = ".nc"

    @classmethod
    def noun(cls) -> str:
        """Return what its answer is called."""
        return cls.folder.removesuffix("s")

    @property
    def settings(self) -> tuple[Any, ...]:
        """What it depends on besides runs; rules rerun when this changes."""
        raise NotImplementedError

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the question with what it is about in a `sim.study.model.Study`.

        Raises ``InputError`` for a series, surrogate, observable or parameter that is not there or
        does not fit, and for measurements that cannot be used.
        """
        raise NotImplementedError

    def with_values(self, **values: Any) -> Self:
        """Return the question with values of attributes that are no keys of the file."""
        return self.model_copy(update=values)

    @property
    def file(self) -> str:
        """Path of the file of its answer in the results of the study."""
        return f"{self.folder}/{self.name}{self.ending}"


def name_field(what: str, among: str) -> Any:
    """Declare the name of a question."""
    return Field(
        pattern=NAME,
        max_length=40,
        description=f"name of the {what} and of its file, unique {among}",
        json_schema_extra={"allowed": ALLOWED_NAME["allowed"].replace("60", "40")},
    )


class SurrogateFile(Question):
    """A surrogate: an observable anywhere between the points of a series, with its error."""

    folder: ClassVar[str] = "surrogates"

    #: What `resolve` adds: the system of the series; the parameters that its points vary; its
    #: design, whose further points are those of rounds; and the figures of papers that these feed.
    system: ClassVar[str]
    axes: ClassVar[tuple[Axis, ...]]
    design: ClassVar[Any] = None
    figures: ClassVar[tuple[str, ...]] = ()

    name: str = name_field("surrogate", "in the study")
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

    def require_rules(self) -> None:
        for key, other in (("error", "budget"), ("budget", "error")):
            has_both = getattr(self, key) is not None or getattr(self, other) is None
            self.require(key, has_both, f"a number, as {other} is given: rounds need both")

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the surrogate with system, parameters and design of its series."""
        if self.series not in place.families:
            raise place.error("series", self.series, "one of " + ", ".join(place.families))
        family = place.families[self.series]
        points = [study.points[key] for key in study.series[self.series]]
        system, design = family.system, study.designs.get(self.series)
        if len(study.readings.get(system, ())) > 1:
            allowed = f"a series of a study with one reading of the {system}"
            raise place.error("series", self.series, allowed)
        # Flows do not depend on numerical parameters of a grid.
        varied = study.axes.get(self.series, ())
        axes = tuple(axis for axis in varied if design or axis.name not in NUMERICAL)
        # Rounds may add what is missing.
        least = 1 if self.has_rounds else fewest_points(len(axes))
        if not least <= len(points) <= MOST_POINTS:
            allowed = f"a series of {least} to {MOST_POINTS:,} points"
            raise place.error("series", f"{self.series} of {len(points):,} points", allowed)
        name = self.observable
        observable = find_observable("curves", "observable", name, system, place.error)
        require_stored(observable, points, partial(place.error, "observable", name))
        require_observables(system, numbers(system))
        if not axes:
            raise place.error("series", self.series, "a series whose points vary a parameter")
        # The points of an analysis belong together, so single ones do not go on with it.
        if self.has_rounds and (design is None or design.kind not in ("sobol", "random")):
            allowed = "with error, a series with a design of kind sobol or random"
            raise place.error("series", self.series, allowed)
        further = design if self.has_rounds else None
        given: dict[str, Any] = {"design": further, "figures": tuple(family.figures)}
        return self.with_values(system=system, axes=axes, **given)

    @property
    def of(self) -> Self:
        """The surrogate itself."""
        return self

    @property
    def mean_regimes(self) -> tuple[str, ...]:
        """Regimes whose points the mean is of, each once."""
        return tuple(dict.fromkeys(self.regimes))

    @property
    def has_rounds(self) -> bool:
        """Whether rounds add points."""
        return self.error is not None

    @property
    def settings(self) -> tuple[Any, ...]:
        """What it and its rounds depend on besides runs; rules rerun when this changes."""
        axes = [(axis.name, axis.low, axis.high, axis.scale, axis.choices) for axis in self.axes]
        rounds = (self.error or 0.0, self.budget or 0.0, self.batch)
        return (self.name, self.series, self.observable, axes, self.mean_regimes, *rounds)

    def further_points(self) -> Iterator[tuple[str, Parameters]]:
        """Yield the points of the design beyond those of the study file, in order, with ids."""
        assert self.design, "only a design goes on"
        for start in range(0, MOST_POINTS, _CHUNK):
            for point in self.design.sequence(_CHUNK, after=self.design.size + start):
                yield point_id(point), point

    def added_points(self, so_far: Container[str]) -> dict[str, Parameters]:
        """Return the further points that rounds have added: those before the first new one."""
        return dict(takewhile(lambda pair: pair[0] in so_far, self.further_points()))

    def next_batch(self, so_far: Container[str]) -> dict[str, Parameters]:
        """Return the next further points that are new, as many as a round adds."""
        further = (pair for pair in self.further_points() if pair[0] not in so_far)
        return dict(islice(further, self.batch))


def surrogate_named(name: str, study: Any, place: Place) -> SurrogateFile:
    """Return the surrogate that a question names; its parameters must all be numbers."""
    named: dict[str, SurrogateFile] = {one.name: one for one in study.surrogates}
    if name not in named:
        allowed = one_of(name, named) if named else "the name of a surrogate"
        raise place.error("surrogate", name, allowed)
    for axis in named[name].axes:
        if not axis.is_number:
            got = f"{name}, which varies {axis.name}"
            raise place.error("surrogate", got, "a surrogate whose parameters are all numbers")
    return named[name]
