"""Entries under ``sensitivity`` of a study file, and what a study knows of them."""

from dataclasses import dataclass
from typing import Any, Self

from pydantic import Field, model_validator

from sim.parameters.common import broken_rule
from sim.study.design import Design
from sim.study.entries import ALLOWED_NAME, NAME, Strict, optional
from sim.study.surrogate import Regime, SurrogateSpec

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
    rough: bool = Field(
        False,
        description="of a surrogate: whether there are indices, too, where its error is too large "
        "to rely on",
    )

    @model_validator(mode="after")
    def _require_one_source(self) -> Self:
        if self.surrogate is None and self.series is None:
            raise broken_rule("surrogate", None, "the name of a surrogate, or series: a series")
        for key in ("series", "observable", "regimes") if self.surrogate is not None else ():
            if (value := getattr(self, key)) is not None:
                raise broken_rule(key, value, "none with surrogate, which has its own")
        if self.rough and self.surrogate is None:
            raise broken_rule("rough", True, "none with series, whose runs need no surrogate")
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
    is_rough : bool
        Whether it is asked of a surrogate whose error is too large to rely on, too.
    """

    name: str
    of: SurrogateSpec
    design: Design | None = None
    is_rough: bool = False

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
        return (self.name, *own, self.is_rough, self.of.settings)
