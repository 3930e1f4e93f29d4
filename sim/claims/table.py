"""The claims of both papers, as the tables beside this module state them."""

import importlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sim.base.errors import InputError
from sim.base.messages import input_error
from sim.base.yaml import read_yaml
from sim.study.catalogue import FIGURES

_TABLES = ("claims_walton.yaml", "claims_gallas.yaml")


class Claim(BaseModel):
    """One claim of a paper and how it is decided."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    id: str = Field(pattern=r"^[WG][1-9][0-9]?$", description="its number, W or G first")
    title: str = Field(min_length=1, description="a few words")
    statement: str = Field(min_length=1, description="what the paper says, in other words")
    place: str = Field(min_length=1, description="section or figure of the paper")
    criterion: str = Field(min_length=1, description="when it holds")
    reason: str = Field("", description="why the criterion is what it is")
    needs: str = Field(description="runs that decide it")
    kind: Literal["model", "flow"] = Field("flow", description="judged by itself or from runs")
    judge: str = Field(pattern=r"^[a-z_]+\.[a-z0-9_]+$", description="module.function")
    figures: list[str] = Field([], description="figures that show it")

    @property
    def paper(self) -> str:
        """``walton`` or ``gallas``."""
        return {"W": "walton", "G": "gallas"}[self.id[0]]

    @property
    def system(self) -> str:
        """System whose runs decide it."""
        return {"W": "chute", "G": "belt"}[self.id[0]]

    def judging(self) -> Callable:
        """Return the function that judges it."""
        module, name = self.judge.split(".")
        return getattr(importlib.import_module(f"sim.claims.{module}"), name)


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    claims: list[Claim] = Field(min_length=1, description="the claims in their order")


@cache
def claims() -> tuple[Claim, ...]:
    """Return all claims in their order."""
    found: list[Claim] = []
    for name in _TABLES:
        path = Path(__file__).parent / name
        try:
            found += _Table.model_validate(read_yaml(path)).claims
        except ValidationError as error:
            raise input_error(error, _Table, name) from None
    for claim in found:
        for figure in claim.figures:
            if figure not in FIGURES:
                raise InputError.of_value(claim.id, "figures", figure, "the name of a figure")
    return tuple(found)
