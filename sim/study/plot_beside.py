"""Data beside a plot's own, of the literature or of an experiment: entries of a study file."""

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from sim.parameters.common import Real, broken_rule
from sim.study.entries import Strict, require_shown

#: Most data beside a plot, each with a look of its own.
MOST_BESIDE = 6

#: Most letters of a label.
_LONGEST = 60

#: Size of a number at most, and on a logarithmic axis its inverse at least: what can be drawn.
LARGEST = 1e100

_LABEL: dict[str, Any] = {"allowed": "a text that is not empty"}
_POINTS: dict[str, Any] = {"allowed": f"a list of points [x, y], numbers of size up to {LARGEST:g}"}

#: A number that can be drawn.
_Drawn = Annotated[Real, Field(ge=-LARGEST, le=LARGEST)]


class BesideFile(Strict):
    """Data that are not of the study, in the units of the plot."""

    label: str = Field(
        pattern=r"\S",
        description=f"what it is, for legend and caption, at most {_LONGEST} letters",
        json_schema_extra=_LABEL,
    )
    points: list[Annotated[list[_Drawn], Field(min_length=2, max_length=2)]] = Field(
        min_length=1,
        description="points [x, y], in the units of the axes as they are drawn",
        json_schema_extra=_POINTS,
    )
    line: bool = Field(False, description="a line through the points, in their order, not markers")

    @model_validator(mode="after")
    def _with_a_label_and_two_ends(self) -> Self:
        require_shown(self.label, "label", _LONGEST)
        if self.line and len(self.points) < 2:
            raise broken_rule("points", self.points, "at least two points for a line")
        return self
