"""The claims of both papers, as read from the tables beside this module."""

import importlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from sim.base.errors import InputError
from sim.base.messages import input_error
from sim.base.yaml import read_yaml
from sim.study.catalogue import FIGURES

#: In place of a paper, for claims of plug-ins.
OWN = "own"

_TABLES = ("claims_walton.yaml", "claims_gallas.yaml")


class First(BaseModel):
    """The first verdict on a claim, on the runs published then."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    verdict: Literal["reproduced", "not reproduced", "inconclusive", "untestable"] = Field(
        description="on the first data"
    )
    criterion: str = Field("", description="the first one, where it was restated")
    why: str = Field("", description="why it was restated, or why the verdict is another now")


class Number(BaseModel):
    """A number that a criterion needs and the paper does not give."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    what: str = Field(min_length=1, description="the number in words")
    values: list[float] = Field(min_length=2, description="those under which it is judged")
    headline: float = Field(description="the one that gives the verdict")
    unit: str = Field("", description="unit of the values")

    @model_validator(mode="after")
    def _has_headline_value(self) -> Self:
        if self.headline not in self.values:
            raise PydanticCustomError("headline", "headline must be one of the values")
        return self


class Claim(BaseModel):
    """One claim of a paper and how it is decided."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    id: str = Field(pattern=r"^[WG][1-9][0-9]?$", description="its number, W or G first")
    title: str = Field(min_length=1, description="a few words")
    statement: str = Field(min_length=1, description="what the paper says, in other words")
    place: str = Field(min_length=1, description="section or figure of the paper")
    criterion: str = Field(min_length=1, description="when it holds")
    reason: str = Field(min_length=1, description="why the criterion is what it is")
    needs: str = Field(description="runs that decide it")
    kind: Literal["model", "flow"] = Field("flow", description="judged by itself or from runs")
    judge: str = Field(pattern=r"^[a-z_]+\.[a-z0-9_]+$", description="module.function")
    figures: list[str] = Field([], description="figures that show it")
    first: First | None = Field(description="how it was judged first")
    parts: dict[str, str] = Field({}, description="what it says, where that is several things")
    contradiction: str = Field("", description="why its parts cannot both hold")
    number: Number | None = Field(None, description="what the paper does not give")

    @property
    def paper(self) -> str:
        """``walton`` or ``gallas``."""
        return {"W": "walton", "G": "gallas"}[self.id[0]]

    @property
    def system(self) -> str:
        """System whose runs decide it."""
        return {"W": "chute", "G": "belt"}[self.id[0]]

    def judge_function(self) -> Callable:
        """Return the judge: a function of the evidence and, if the claim has one, of a number."""
        module, name = self.judge.split(".")
        return getattr(importlib.import_module(f"sim.claims.{module}"), name)


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    claims: list[Claim] = Field(min_length=1, description="the claims in their order")


@cache
def claims() -> tuple[Claim, ...]:
    """Return all claims in their order."""
    all_claims: list[Claim] = []
    for name in _TABLES:
        path = Path(__file__).parent / name
        try:
            all_claims += _Table.model_validate(read_yaml(path)).claims
        except ValidationError as error:
            raise input_error(error, _Table, name) from None
    for claim in all_claims:
        for figure in claim.figures:
            if figure not in FIGURES:
                raise InputError.of_value(claim.id, "figures", figure, "the name of a figure")
    return tuple(all_claims)
