"""Entries under ``sensitivity`` of a study file: what matters."""

from collections.abc import Iterator
from typing import Any, ClassVar, Self

from pydantic_core import PydanticCustomError

from sim.parameters.common import Real, broken_rule
from sim.parameters.density import DENSITY
from sim.study.design import DesignFile, block_size
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


class SensitivityFile(Question):
    """What matters: indices of a surrogate, or of the runs of a design made for them."""

    folder: ClassVar[str] = "sensitivity"
    ending: ClassVar[str] = ".csv"

    #: What `resolve` adds: the surrogate, or what one of the series would be; and the design of the
    #: series whose runs are analysed.
    of: ClassVar[SurrogateFile]
    design: ClassVar[DesignFile | None] = None

    name: str = name_field("answer", "among sensitivities")
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

    def rules(self) -> Iterator[PydanticCustomError]:
        if self.surrogate is None and self.series is None:
            yield broken_rule("surrogate", None, "the name of a surrogate, or series: a series")
        for key in ("series", "observable", "regimes") if self.surrogate is not None else ():
            if (value := getattr(self, key)) is not None:
                yield broken_rule(key, value, "none with surrogate, which has its own")
        if self.surrogate is None and (value := self.surrogate_error) is not None:
            rule = "none with series, whose runs need no surrogate"
            yield broken_rule("surrogate_error", value, rule)

    def resolve(self, study: Any, place: Place) -> Self:
        """Return the question with its surrogate, or with the design of its series."""
        if self.surrogate is not None:
            of = surrogate_named(self.surrogate, study, place)
            return self.with_values(of=of)
        name = self.series
        design = study.designs.get(name)
        if design is None or design.kind not in ("saltelli", "morris"):
            others = [key for key, one in study.designs.items() if block_size(one.kind, 2) > 1]
            hint = f": {', '.join(others)}" if others else ""
            allowed = f"a series whose design is of kind saltelli or morris{hint}"
            raise place.error("series", name, allowed)
        if DENSITY in design.names:
            raise place.error("series", name, f"a series whose design is over mass, not {DENSITY}")
        fewest = FEWEST_BLOCKS * block_size(design.kind, len(design.axes))
        if design.size < fewest:
            got = f"{name} of {design.size} points"
            raise place.error("series", got, f"a design of {fewest} points or more")
        system = study.points[study.series[name][0]].parameters.system
        observable = self.observable or "velocity"
        find_observable("curves", "observable", observable, system, place.error)
        regimes = self.regimes or list(COUNTED)
        of = SurrogateFile(name=self.name, series=name, observable=observable, regimes=regimes)
        return self.with_values(of=of.about(system, design.axes), design=design)

    @property
    def is_screening(self) -> bool:
        """Whether it is Morris' screening."""
        return self.design is not None and self.design.kind == "morris"

    @property
    def settings(self) -> tuple[Any, ...]:
        own = (self.design.kind, self.design.size, self.design.seed) if self.design else ()
        return (self.name, *own, self.surrogate_error, self.of.settings)
