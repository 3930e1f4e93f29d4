"""Entries under ``sensitivity`` of a study file, and what a study knows of them."""

from dataclasses import dataclass
from typing import Any, Self

from pydantic import Field, model_validator

from sim.parameters.common import Real, broken_rule
from sim.study.design import Design
from sim.study.entries import ALLOWED_NAME, NAME, Strict, optional
from sim.study.surrogate import ACCEPTED_ERROR, Regime, SurrogateSpec

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
