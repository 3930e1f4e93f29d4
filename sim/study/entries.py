"""Entries of a study file, whatever their system: parameters, series, boundaries, overrides."""

from itertools import chain
from typing import TYPE_CHECKING, Any, ClassVar, Self, get_args
from unicodedata import category

from pydantic import BaseModel, ConfigDict, Field, model_validator

from sim.base.additions import additions
from sim.parameters import AMOUNTS, SYSTEMS, Parameters
from sim.parameters.common import Real, broken_rule
from sim.study.papers import papers
from sim.study.refine import MAX_ROUNDS, PARTS, further_rounds

#: Unicode categories without letters, some of which move the cursor or reverse the line where a
#: title is shown; and the maximum length of a title.
_UNPRINTABLE, _MAX_TITLE_LENGTH = ("Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"), 300


def require_printable(text: str, key: str = "title", max_length: int = _MAX_TITLE_LENGTH) -> None:
    """Raise the error of a validator unless a text is one line of printable letters."""
    if len(text) > max_length or any(category(letter) in _UNPRINTABLE for letter in text):
        allowed = f"one line of at most {max_length} letters, without control or direction marks"
        raise broken_rule(key, text, allowed)


class Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def optional(
    description: str | None, json_schema: dict[str, Any] | None = None, **options: Any
) -> Any:
    """Declare an optional key: ``None`` if the file omits it, but null is not a valid value.

    A key without a value is a mistake, not a request for the default. ``json_schema`` holds
    further entries for the JSON schema.
    """

    def adapt_schema(schema: dict[str, Any]) -> None:
        schema.pop("default", None)
        schema.update(json_schema or {})

    adapt_schema.allowed = (json_schema or {}).get("allowed", "")  # type: ignore[attr-defined]
    return Field(None, description=description, json_schema_extra=adapt_schema, **options)


class Some(Strict):
    """Values of some parameters of a system; only those given are set."""

    parameters: ClassVar[type[Parameters]]

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return a hint at the intended value or key, empty if there is none."""
        if isinstance(value, list) and not issubclass(cls, Lists):
            return "a list of values belongs under grid"
        if system_hint := getattr(cls.parameters, "hint", lambda key, value: "")(key, value):
            return str(system_hint)
        systems = [name for name, model in SYSTEMS.items() if key in model.model_fields]
        system = cls.parameters.model_fields["system"].default
        text = f"{key} is a parameter of the {' and the '.join(systems)}"
        return text if systems and system not in systems else ""

    def explicit_values(self) -> dict[str, Any]:
        """Return the values that the file sets here, with numbers in canonical form."""
        return self.model_dump(exclude_unset=True)


class Lists(Some):
    """Lists of values of some parameters of a system, at least of one."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    @model_validator(mode="after")
    def _require_one_parameter(self) -> Self:
        if not self.model_fields_set:
            raise broken_rule("", {}, "at least one parameter with a list of values")
        return self


class Readings(Lists):
    """Lists of readings of the paper; of each the first is the one that figures show."""


class Override(Strict):
    """Parameters that change at the points where others have certain values."""

    when: Lists = Field(description="values that a point must have, each one of its list")
    set: Some = Field(description="parameters to set at those points")


NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]*$"
ALLOWED_NAME: dict[str, Any] = {
    "allowed": "up to 60 letters, digits, '-' and '_', a letter or digit first"
}


class _Family(Strict):
    """Points or boundaries of one system that share most of their parameters."""

    system_of_figures: ClassVar[dict[str, str]] = {}

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return a hint at the intended value or key, empty if there is none."""
        if key == "figures" and isinstance(value, str) and value in cls.system_of_figures:
            (system,) = get_args(cls.model_fields["system"].annotation)
            return f"a figure of the {system}; {value} is one of the {cls.system_of_figures[value]}"
        if any(key in model.model_fields for model in SYSTEMS.values()):
            return "parameters belong under base, grid or cases"
        return ""

    name: str = Field(
        pattern=NAME,
        max_length=60,
        description="name, unique in the study",
        json_schema_extra=ALLOWED_NAME,
    )
    system: str = Field(description="which of the systems")
    base: Some = optional("parameters shared by all points")
    grid: Lists = optional("one point (boundary) for every combination of the values listed")

    if TYPE_CHECKING:
        # The subclasses declare it, so that it follows their own keys in the reference.
        overrides: list[Override]

    @model_validator(mode="after")
    def _require_overrides_outside_grid(self) -> Self:
        grid_names = self.grid.model_fields_set if self.grid else set()
        for index, override in enumerate(self.overrides):
            for name in sorted(grid_names & override.set.model_fields_set):
                key = f"overrides[{index}].set.{name}"
                value = getattr(override.set, name)
                raise broken_rule(key, value, f"parameters other than grid.{name} of the series")
        return self

    @model_validator(mode="after")
    def _require_one_amount_in_grid(self) -> Self:
        for name in sorted(self.grid.model_fields_set & AMOUNTS if self.grid else ()):
            values = getattr(self.grid, name)
            if len(values) > 1:
                allowed = "one value: how much of a point is run tells no points apart"
                raise broken_rule(f"grid.{name}", values, allowed)
        return self


class SeriesFile(_Family):
    """A series of points. Without grid and cases, the base is its one point."""

    cases: list[Some] = optional("further points, each with the parameters given", min_length=1)
    overrides: list[Override] = Field([], description="changes at certain values")
    figures: list[str] = Field([], description="figures that the series feeds")


#: Kind of the plug-in additions that judge claims.
JUDGE = "judge"


class DecideFile(Strict):
    """What is to be decided by more replicates and longer runs, added in rounds."""

    budget: Real = Field(description="core hours that all rounds may add", gt=0, le=1e6)
    claims: list[str] = optional(
        "claims of the papers to be decided, as G3; [all] for all that the study tests; under each "
        "of the study's readings",
        min_length=1,
    )
    precision: Real = optional(
        "half width of the 95 % interval of the mean velocity, relative to it, that is wanted of "
        "every steady flow",
        ge=0.001,
        le=0.5,
    )
    replicates: int = Field(100, description="most replicates of a point", ge=2, le=1000)
    longer: Real = Field(
        8, description="most times as long as the study has it that a run may become", ge=1, le=1000
    )

    @model_validator(mode="after")
    def _require_goal(self) -> Self:
        for index, name in enumerate(self.claims or []):
            _require_claim(f"claims[{index}]", name)
        if self.claims is None and self.precision is None:
            raise broken_rule("claims", None, "claims, precision, or both")
        return self


def _require_claim(key: str, name: str) -> None:
    """Refuse anything but the id of a claim or ``all``."""
    ids = [[claim["id"] for claim in paper.claims] for paper in papers().values()]
    if name != "all" and name not in {*chain(*ids), *additions(JUDGE)}:
        ranges = ", ".join(f"{one[0]} to {one[-1]}" for one in ids if one)
        raise broken_rule(key, name, f"{ranges}, all, or the name of a judge of a plug-in")


class BoundaryFile(_Family):
    """A boundary between regimes, for each combination of the grid."""

    of: str = Field(description="what changes there")
    along: str = Field(description="parameter along which it is looked for")
    range: list[Real] = Field(
        description="lowest and highest value of that parameter",
        min_length=2,
        max_length=2,
        json_schema_extra={"allowed": "two numbers, the lower one first"},
    )
    tolerance: Real = Field(description="width of the interval to find the boundary in", gt=0)
    overrides: list[Override] = Field([], description="changes at certain values")
    figures: list[str] = Field([], description="figures that are fed")

    @model_validator(mode="after")
    def _require_valid_range(self) -> Self:
        low, high = self.range
        if not low < high:
            raise broken_rule("range", self.range, "two numbers, the lower one first")
        if further_rounds(low, high, self.tolerance) > MAX_ROUNDS:
            finest = (high - low) / PARTS ** (MAX_ROUNDS + 1)
            raise broken_rule("tolerance", self.tolerance, f"a number >= {1.01 * finest:.3g}")
        return self

    @model_validator(mode="after")
    def _require_along_unset(self) -> Self:
        sections = {"base": self.base, "grid": self.grid}
        sections |= {
            f"overrides[{i}].set": override.set for i, override in enumerate(self.overrides)
        }
        for path, section in sections.items():
            if section and self.along in section.model_fields_set:
                value = getattr(section, self.along)
                allowed = f"parameters other than {self.along}, which the boundary is along"
                raise broken_rule(f"{path}.{self.along}", value, allowed)
        return self
