"""What a study file may contain, as pydantic models: validation, schema and reference in one."""

from typing import Annotated, Any, ClassVar, Generic, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model, model_validator

from sim.base.messages import input_error
from sim.parameters import SYSTEMS, BeltParameters, ChuteParameters, Parameters
from sim.parameters.common import Real, broken_rule
from sim.study.catalogue import FIGURES
from sim.study.refine import MAX_ROUNDS, PARTS, further_rounds

_SomeT = TypeVar("_SomeT")
_ListsT = TypeVar("_ListsT")


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def _optional(description: str | None, **options: Any) -> Any:
    """Declare a key that may be left out, when it reads as ``None``, but not be given as null.

    A key with nothing behind it is a slip, not a wish for the default.
    """
    return Field(
        None,
        description=description,
        json_schema_extra=lambda schema: schema.pop("default", None),
        **options,
    )


class _Some(_Strict):
    """Values of some parameters of a system; only those given are set."""

    parameters: ClassVar[type[Parameters]]

    def given(self) -> dict[str, Any]:
        """Return what the file gives here, numbers in canonical form."""
        return self.model_dump(exclude_unset=True)


class _Lists(_Some):
    """Lists of values of some parameters of a system, at least of one."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    @model_validator(mode="after")
    def _of_one_parameter_at_least(self) -> Self:
        if not self.model_fields_set:
            raise broken_rule("", {}, "at least one parameter with a list of values")
        return self


def _derived(base: type[_Some], model: type[Parameters], name: str) -> type[_Some]:
    """Make ``base`` concrete with the parameters of a system, each of them optional."""
    fields: dict[str, Any] = {}
    for key, declared in model.model_fields.items():
        value = declared.annotation
        if declared.metadata:
            value = Annotated[(value, *declared.metadata)]
        if issubclass(base, _Lists):
            value = Annotated[list[value], Field(min_length=1)]
        fields[key] = value, _optional(declared.description)
    del fields["system"]
    derived = create_model(name, __base__=base, __doc__=base.__doc__, **fields)
    derived.parameters = model
    return derived


ChuteSome = _derived(_Some, ChuteParameters, "ChuteSome")
ChuteLists = _derived(_Lists, ChuteParameters, "ChuteLists")
BeltSome = _derived(_Some, BeltParameters, "BeltSome")
BeltLists = _derived(_Lists, BeltParameters, "BeltLists")


class _Override(_Strict, Generic[_SomeT, _ListsT]):
    """Parameters that change at the points where others have certain values."""

    when: _ListsT = Field(description="values that a point must have, each one of its list")
    set: _SomeT = Field(description="parameters to set at those points")


class ChuteOverride(_Override[ChuteSome, ChuteLists]):
    """Parameters of the chute that change at the points where others have certain values."""


class BeltOverride(_Override[BeltSome, BeltLists]):
    """Parameters of the belt that change at the points where others have certain values."""


_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]*$"
#: Names of folders of results that are no study's: where published studies lie.
_RESERVED = ("published",)
_ALLOWED_NAME = {"allowed": "up to 60 letters, digits, '-' and '_', a letter or digit first"}


def _figures_of(*systems: str) -> Any:
    """Return the type of the name of a figure that these systems can feed."""
    return Literal[tuple(name for name, spec in FIGURES.items() if spec.system in systems)]


class _Family(_Strict, Generic[_SomeT, _ListsT]):
    name: str = Field(
        pattern=_NAME,
        max_length=60,
        description="name, unique in the study",
        json_schema_extra=_ALLOWED_NAME,
    )
    system: str = Field(description="which of the two systems")
    base: _SomeT = _optional("parameters shared by all points")
    grid: _ListsT = _optional("one point (boundary) for every combination of the values listed")

    @model_validator(mode="after")
    def _overrides_leave_the_grid_alone(self) -> Self:
        varied = self.grid.model_fields_set if self.grid else set()
        for index, override in enumerate(self.overrides):
            for name in sorted(varied & override.set.model_fields_set):
                key = f"overrides[{index}].set.{name}"
                value = getattr(override.set, name)
                raise broken_rule(key, value, f"parameters other than grid.{name} of the series")
        return self


class _Series(_Family[_SomeT, _ListsT], Generic[_SomeT, _ListsT]):
    cases: list[_SomeT] = _optional("further points, each with the parameters given", min_length=1)


class ChuteSeries(_Series[ChuteSome, ChuteLists]):
    """A series of points of the chute. Without grid and cases, the base is its one point."""

    system: Literal["chute"] = Field(description="which of the two systems")
    overrides: list[ChuteOverride] = Field([], description="changes at certain values")
    figures: list[_figures_of("chute")] = Field([], description="figures that the series feeds")


class BeltSeries(_Series[BeltSome, BeltLists]):
    """A series of points of the belt. Without grid and cases, the base is its one point."""

    system: Literal["belt"] = Field(description="which of the two systems")
    overrides: list[BeltOverride] = Field([], description="changes at certain values")
    figures: list[_figures_of("belt")] = Field([], description="figures that the series feeds")


def _numbers_of(system: str) -> Any:
    """Return the type of the name of a parameter of a system that is a real number."""
    fields = SYSTEMS[system].model_fields.items()
    return Literal[tuple(name for name, field in fields if field.annotation is float)]


class _Boundary(_Family[_SomeT, _ListsT], Generic[_SomeT, _ListsT]):
    of: str = Field(description="what changes there")
    along: str = Field(description="parameter along which the boundary is looked for")
    range: list[Real] = Field(
        description="lowest and highest value of that parameter",
        min_length=2,
        max_length=2,
        json_schema_extra={"allowed": "two numbers, the lower one first"},
    )
    tolerance: Real = Field(description="width of the interval to find the boundary in", gt=0)

    @model_validator(mode="after")
    def _range_and_tolerance_fit(self) -> Self:
        low, high = self.range
        if not low < high:
            raise broken_rule("range", self.range, "two numbers, the lower one first")
        if further_rounds(low, high, self.tolerance) > MAX_ROUNDS:
            finest = (high - low) / PARTS ** (MAX_ROUNDS + 1)
            raise broken_rule("tolerance", self.tolerance, f"a number >= {1.01 * finest:.3g}")
        return self

    @model_validator(mode="after")
    def _one_place_sets_what_the_boundary_is_along(self) -> Self:
        places = {"base": self.base, "grid": self.grid}
        places |= {f"overrides[{i}].set": one.set for i, one in enumerate(self.overrides)}
        for path, place in places.items():
            if place and self.along in place.model_fields_set:
                value = getattr(place, self.along)
                allowed = f"parameters other than {self.along}, which the boundary is along"
                raise broken_rule(f"{path}.{self.along}", value, allowed)
        return self


class ChuteBoundary(_Boundary[ChuteSome, ChuteLists]):
    """A boundary between regimes of the chute, for each combination of the grid."""

    system: Literal["chute"] = Field(description="which of the two systems")
    of: Literal["flow", "acceleration"] = Field(
        description="what changes there: flow (arrested or not), acceleration (accelerating or "
        "not), transport (belt: mean velocity beyond 2 % of the belt's or not)"
    )
    along: _numbers_of("chute") = Field(description="parameter along which it is looked for")
    overrides: list[ChuteOverride] = Field([], description="changes at certain values")
    figures: list[_figures_of("chute")] = Field([], description="figures that are fed")


class BeltBoundary(_Boundary[BeltSome, BeltLists]):
    """A boundary between regimes of the belt, for each combination of the grid."""

    system: Literal["belt"] = Field(description="which of the two systems")
    of: Literal["flow", "transport"] = Field(description="what changes there")
    along: _numbers_of("belt") = Field(description="parameter along which it is looked for")
    overrides: list[BeltOverride] = Field([], description="changes at certain values")
    figures: list[_figures_of("belt")] = Field([], description="figures that are fed")


class Defaults(_Strict):
    """Parameters shared by all series of a system."""

    chute: ChuteSome = _optional("shared by all series of the chute")
    belt: BeltSome = _optional("shared by all series of the belt")


class StudyFile(_Strict):
    """A study: series of points, boundaries to be found, and the figures they feed."""

    model_config = ConfigDict(
        json_schema_extra={
            "anyOf": [{"required": [key]} for key in ("series", "boundaries", "parts")]
        }
    )

    study: str = Field(
        pattern=_NAME,
        max_length=60,
        description="name of the study and of its folder of results, not published",
        json_schema_extra=_ALLOWED_NAME | {"not": {"enum": list(_RESERVED)}},
    )
    title: str = Field("", description="one line for the report")
    figures: list[_figures_of(*SYSTEMS)] = _optional(
        "all figures of the study, each fed by a series (omitted: those that are fed)"
    )
    defaults: Defaults = Field(Defaults(), description="parameters shared by series")
    series: list[Annotated[ChuteSeries | BeltSeries, Field(discriminator="system")]] = _optional(
        "the series of points (omitted: none, if there are boundaries or parts)", min_length=1
    )
    boundaries: list[Annotated[ChuteBoundary | BeltBoundary, Field(discriminator="system")]] = (
        _optional("boundaries between regimes, found by refinement", min_length=1)
    )

    parts: list[
        # A lone hyphen would be standard input.
        Annotated[
            str,
            Field(
                pattern=r"^([^/\\-]|[^/\\]{2,})$", json_schema_extra={"allowed": "a file's name"}
            ),
        ]
    ] = _optional(
        "study files in the same folder whose points, boundaries and figures this one has too",
        min_length=1,
    )

    @model_validator(mode="after")
    def _of_a_name_of_its_own(self) -> Self:
        if self.study in _RESERVED:
            allowed = f"a name other than {', '.join(_RESERVED)}, where published studies lie"
            raise broken_rule("study", self.study, allowed)
        return self

    @model_validator(mode="after")
    def _of_some_points(self) -> Self:
        if not self.series and not self.boundaries and not self.parts:
            raise broken_rule("series", None, "at least one series, boundaries, or parts")
        return self


def validated(mapping: Any, source: str) -> StudyFile:
    """Validate the contents of a study file; the points themselves come later.

    Raises
    ------
    InputError
        Naming file, key, value and what is allowed.
    """
    try:
        return StudyFile.model_validate(mapping)
    except ValidationError as error:
        raise input_error(error, StudyFile, source) from None
