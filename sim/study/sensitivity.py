"""Entries under ``sensitivity`` and ``propagate`` of a study file: what matters, and what follows.

Both are asked of a surrogate, or of the runs of a design made for them.
"""

from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, ValidationError
from pydantic_core import PydanticCustomError

from sim.base.messages import one_of
from sim.parameters.common import Real
from sim.parameters.density import DENSITY
from sim.study.design import Axis, block_size
from sim.study.design_file import ALLOWED_VALUES, distribution, read_values
from sim.study.entries import optional
from sim.study.plottable import find_observable
from sim.study.surrogate import (
    ACCEPTED_ERROR,
    COUNTED,
    Place,
    Question,
    Regime,
    SurrogateFile,
    name_field,
    surrogate_named,
)

#: Fewest blocks, or trajectories of Morris, that give an answer.
FEWEST_BLOCKS = 8


class _OfSurrogateOrRuns(Question):
    """A question that a surrogate answers, or the runs of a design made for it."""

    ending: ClassVar[str] = ".csv"

    #: Kinds of design whose runs can answer it, and what `resolve` adds: the surrogate, or what one
    #: of the series would be; and the design of the series whose runs are analysed.
    kinds: ClassVar[tuple[str, ...]]
    of: ClassVar[SurrogateFile]
    design: ClassVar[Any] = None

    name: str
    surrogate: str = optional("surrogate whose observable is explained")
    series: str = optional("in place of a surrogate: series with a design")
    observable: str = optional("of a series: observable, any number of `plots` (velocity)")
    regimes: list[Regime] = optional(
        "of a series: regimes whose points count (steady, mixed, undetermined); others, and blocks "
        "with them, are left out",
        min_length=1,
    )
    surrogate_error: Real = optional(f"of a surrogate: {ACCEPTED_ERROR}", gt=0, le=10)

    def require_rules(self) -> None:
        if self.surrogate is not None:
            for key in ("series", "observable", "regimes"):
                is_left = getattr(self, key) is None
                self.require(key, is_left, "none with surrogate, which has its own")
            return
        self.require("surrogate", self.series, "the name of a surrogate, or series: a series")
        allowed = "none with series, whose runs need no surrogate"
        self.require("surrogate_error", self.surrogate_error is None, allowed)

    def fewest(self, design: Any) -> int:
        """Return the fewest points of a design whose runs give an answer."""
        raise NotImplementedError

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the question with its surrogate, or with the design of its series."""
        if self.surrogate is not None:
            return self.with_values(of=surrogate_named(self.surrogate, study, place))
        name = self.series
        design = study.designs.get(name)
        if design is None or design.kind not in self.kinds:
            others = [key for key, one in study.designs.items() if one.kind in self.kinds]
            hint = f": {', '.join(others)}" if others else ""
            allowed = f"a series whose design is of kind {' or '.join(self.kinds)}{hint}"
            raise place.error("series", name, allowed)
        if DENSITY in design.names:
            raise place.error("series", name, f"a series whose design is over mass, not {DENSITY}")
        if design.size < (fewest := self.fewest(design)):
            allowed = f"a design of {fewest} points or more"
            raise place.error("series", f"{name} of {design.size} points", allowed)
        system = study.points[study.series[name][0]].parameters.system
        observable = self.observable or "velocity"
        find_observable("curves", "observable", observable, system, place.error)
        regimes = self.regimes or list(COUNTED)
        of = SurrogateFile(name=self.name, series=name, observable=observable, regimes=regimes)
        return self.with_values(of=of.about(system, design.axes), design=design)

    @property
    def settings(self) -> tuple[Any, ...]:
        own = (self.design.kind, self.design.size, self.design.seed) if self.design else ()
        return (self.name, *own, self.surrogate_error, self.of.settings)


class SensitivityFile(_OfSurrogateOrRuns):
    """What matters: indices of a surrogate, or of the runs of a design made for them."""

    folder: ClassVar[str] = "sensitivity"
    kinds: ClassVar[tuple[str, ...]] = ("saltelli", "morris")

    name: str = name_field("answer", "among sensitivities")
    series: str = optional(
        "in place of a surrogate: series whose design is of kind `saltelli` or `morris`"
    )

    def fewest(self, design: Any) -> int:
        """Return the points of the fewest blocks."""
        return FEWEST_BLOCKS * block_size(design.kind, len(design.axes))

    @property
    def is_screening(self) -> bool:
        """Whether it is Morris' screening."""
        return self.design is not None and self.design.kind == "morris"


#: Fewest runs that give a spread.
FEWEST_RUNS = 8


class PropagationFile(_OfSurrogateOrRuns):
    """How an observable is spread where parameters are: by a surrogate, or by runs."""

    folder: ClassVar[str] = "propagation"
    kinds: ClassVar[tuple[str, ...]] = ("sobol", "latin_hypercube", "random")

    #: What `resolve` adds of a surrogate: how its parameters are spread, and conditions on them.
    axes: ClassVar[tuple[Axis, ...]] = ()
    where: ClassVar[tuple[str, ...]] = ()

    name: str = name_field("answer", "among propagations")
    series: str = optional(
        "in place of a surrogate: series whose design is of kind `sobol`, `latin_hypercube` or "
        "`random`"
    )
    over: dict[str, Any] = optional(
        "of a surrogate: how parameters are spread, as in a design (omitted: as in its own)"
    )
    quantiles: list[Annotated[Real, Field(gt=0, lt=1)]] = Field(
        [0.05, 0.25, 0.5, 0.75, 0.95], description="quantiles asked for", min_length=1
    )
    exceeds: list[Real] = Field(
        [], description="values, in SI units, of which the probability to exceed them is asked for"
    )

    def require_rules(self) -> None:
        super().require_rules()
        is_possible = self.surrogate is not None or self.over is None
        self.require("over", is_possible, "none with series, whose design has them")

    def fewest(self, design: Any) -> int:
        """Return the fewest runs."""
        return FEWEST_RUNS

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the question with the distributions of its parameters."""
        asked = super().resolve(study, place)
        if asked.design is not None:
            return asked
        design = study.designs.get(asked.of.series)
        known = {axis.name: axis for axis in asked.of.axes}
        for name, value in (self.over or {}).items():
            if name not in known:
                raise place.error(f"over.{name}", value, one_of(name, known))
            known[name] = _spread(known[name], value, place)
        where = tuple((design and design.where) or ())
        return asked.with_values(axes=tuple(known.values()), where=where)

    @property
    def settings(self) -> tuple[Any, ...]:
        spread = tuple((axis.name, axis.low, axis.high, axis.normal) for axis in self.axes)
        return (*super().settings, spread, tuple(self.quantiles), tuple(self.exceeds))


def _spread(axis: Axis, value: Any, place: Place) -> Axis:
    """Return how a parameter of a surrogate is spread by a value under ``over``."""
    try:
        spread = distribution(read_values(value)).axis(axis.name, axis.is_integer)
    except (ValidationError, PydanticCustomError):
        raise place.error(f"over.{axis.name}", value, ALLOWED_VALUES) from None
    if not axis.low <= spread.low < spread.high <= axis.high or not spread.is_number:
        allowed = f"values within [{axis.low:g}, {axis.high:g}], that of its surrogate"
        raise place.error(f"over.{axis.name}", value, allowed)
    return spread
