"""Entries of a study file for data beside a plot's own, from literature or experiments."""

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from sim.parameters.common import Real, broken_rule
from sim.study.entries import Strict, require_printable

#: Maximum number of data sets beside a plot; each has a style of its own.
MAX_BESIDE = 6

#: Maximum length of a label.
_MAX_LABEL_LENGTH = 60

#: Largest magnitude of a number that can be drawn; on a logarithmic axis, its inverse is the least.
MAX_MAGNITUDE = 1e100

_LABEL: dict[str, Any] = {"allowed": "a text that is not empty"}
_POINTS: dict[str, Any] = {
    "allowed": f"a list of points [x, y], numbers of size up to {MAX_MAGNITUDE:g}"
}

#: A number that can be drawn.
_DrawableNumber = Annotated[Real, Field(ge=-MAX_MAGNITUDE, le=MAX_MAGNITUDE)]


class BesideFile(Strict):
    """Data that are not of the study, in the units of the plot."""

    label: str = Field(
        pattern=r"\S",
        description=f"what it is, for legend and caption, at most {_MAX_LABEL_LENGTH} letters",
        json_schema_extra=_LABEL,
    )
    points: list[Annotated[list[_DrawableNumber], Field(min_length=2, max_length=2)]] = Field(
        min_length=1,
        description="points [x, y], in the units of the axes as they are drawn",
        json_schema_extra=_POINTS,
    )
    line: bool = Field(False, description="a line through the points, in their order, not markers")

    @model_validator(mode="after")
    def _require_label_and_line_ends(self) -> Self:
        require_printable(self.label, "label", _MAX_LABEL_LENGTH)
        if self.line and len(self.points) < 2:
            raise broken_rule("points", self.points, "at least two points for a line")
        return self
