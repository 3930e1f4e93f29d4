"""What a study file may contain, as pydantic models: validation, schema and reference in one."""

from collections.abc import Collection, Iterable, Mapping
from functools import cache, reduce
from operator import or_
from types import GenericAlias
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    create_model,
    model_validator,
)

from sim.base.messages import input_error
from sim.base.plugins import ALLOWED, PATTERN
from sim.parameters import SYSTEMS, Parameters, roles
from sim.parameters.common import broken_rule
from sim.study.catalogue import FIGURES
from sim.study.entries import (
    ALLOWED_NAME,
    NAME,
    BoundaryFile,
    DecideFile,
    Lists,
    Override,
    Readings,
    SeriesFile,
    Some,
    Strict,
    optional,
    require_shown,
)
from sim.study.plot_file import PlotFile
from sim.study.ranges import expanded, expanded_integers, with_ranges

#: Names of folders of results that are no study's: where published studies lie.
_RESERVED = ("published",)

#: Of the first system, in whose words the reference tells the keys of a boundary.
_WHAT_CHANGES = (
    "what changes there: flow (arrested or not), acceleration (accelerating or not), transport "
    "(belt: mean velocity beyond 10 % of the belt's or not)"
)

#: Figures of a system that feeds none.
_NONE_YET = Annotated[list[str], Field(max_length=0)]


class Models(NamedTuple):
    """What a study file may contain of one system."""

    some: type[Some]
    readings: type[Lists]
    override: type[Override]
    series: type[SeriesFile]
    boundary: type[BoundaryFile]


def _models_of(system: str) -> Models:
    """Make the models of the entries of a study file concrete with the parameters of a system."""
    model, first = SYSTEMS[system], next(iter(SYSTEMS))
    # No boundary is along what no flow depends on: lengths of runs, how often samples are taken.
    idle = roles.numerical(model) - set(roles.changing_start(model))
    numbers = [
        name
        for name, field in model.model_fields.items()
        if field.annotation is float and name not in idle
    ]
    figures = [name for name, spec in FIGURES.items() if spec.system == system]
    some, lists = _given(Some, system), _given(Lists, system)
    readings = _given(Readings, system, roles.readings(model))
    override = _concrete(
        Override,
        system,
        f"Parameters of the {system} that change at the points where others have certain values.",
        {"when": lists, "set": some},
    )
    shared: dict[str, Any] = {
        "system": Literal[system],
        "base": some,
        "grid": lists,
        "overrides": _list_of(override),
        "figures": _list_of(Literal[tuple(figures)]) if figures else _NONE_YET,
    }
    series = _concrete(
        SeriesFile,
        system,
        f"A series of points of the {system}. Without grid and cases, the base is its one point.",
        shared | {"cases": _list_of(some)},
    )
    boundary = _concrete(
        BoundaryFile,
        system,
        f"A boundary between regimes of the {system}, for each combination of the grid.",
        shared | {"of": Literal[model.boundaries], "along": Literal[tuple(numbers)]},
        **({"of": Field(description=_WHAT_CHANGES)} if system == first else {}),
    )
    return Models(some, readings, override, series, boundary)


def _given(base: type[Some], system: str, names: Collection[str] | None = None) -> Any:
    """Make ``base`` concrete with the parameters of a system, or some of them, each optional."""
    fields: dict[str, Any] = {}
    for key, declared in SYSTEMS[system].model_fields.items():
        if key == "system" or (names is not None and key not in names):
            continue
        value: Any = declared.annotation
        if declared.metadata:
            value = Annotated[(value, *declared.metadata)]
        said = optional(declared.description)
        if issubclass(base, Lists):
            value = Annotated[_list_of(value), Field(min_length=1)]
            if declared.annotation in (int, float):
                spread = expanded_integers if declared.annotation is int else expanded
                value = Annotated[value, BeforeValidator(spread)]
                said = Field(None, description=declared.description, json_schema_extra=with_ranges)
        fields[key] = value, said
    name = f"{system.capitalize()}{base.__name__}"
    made = create_model(name, __base__=base, __doc__=base.__doc__, **fields)
    made.parameters = SYSTEMS[system]
    return made


def _concrete(
    base: type[BaseModel], system: str, doc: str, types: dict[str, Any], **said: Any
) -> Any:
    """Give fields of ``base`` the types that they have in a system; ``said`` replaces others."""
    fields: dict[str, Any] = {
        name: (kind, said.get(name, base.model_fields[name])) for name, kind in types.items()
    }
    name = f"{system.capitalize()}{base.__name__.removesuffix('File')}"
    return create_model(name, __base__=base, __doc__=doc, **fields)


def _list_of(kind: Any) -> Any:
    """Return the type of a list of entries whose type is not known before the program runs."""
    return GenericAlias(list, (kind,))


def _any_of(kinds: Iterable[type[BaseModel]]) -> Any:
    """Return the type of an entry of any system, which its key ``system`` tells."""
    return Annotated[reduce(or_, kinds), Field(discriminator="system")]


def _by_system(systems: Mapping[str, Models], kind: str, said: str) -> dict[str, Any]:
    """Return a key for each system that may be left out, with one of its `Models` behind it."""
    return {
        system: (getattr(one, kind), optional(said.format(system)))
        for system, one in systems.items()
    }


if TYPE_CHECKING:
    # What the type below is at most, for a reader that does not run the catalogue.
    _FigureName = str
else:
    _FigureName = Literal[tuple(FIGURES)]


class StudyFile(Strict):
    """A study: series of points, boundaries to be found, and the figures they feed.

    `file_models` makes its keys concrete with the parameters of the systems.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "anyOf": [{"required": [key]} for key in ("series", "boundaries", "parts")]
        }
    )

    study: str = Field(
        pattern=NAME,
        max_length=60,
        description="name of the study and of its folder of results, not published",
        json_schema_extra=ALLOWED_NAME | {"not": {"enum": list(_RESERVED)}},
    )
    title: str = Field("", description="one line for the report")
    figures: list[_FigureName] = optional(
        "all figures of the study, each fed by a series (omitted: those that are fed)"
    )
    defaults: Strict = Field(Strict(), description="parameters shared by series")
    readings: Strict = Field(
        Strict(), description="readings of the papers under which every series is run"
    )
    series: list[SeriesFile] = optional(
        "the series of points (omitted: none, if there are boundaries or parts)", min_length=1
    )
    boundaries: list[BoundaryFile] = optional(
        "boundaries between regimes, found by refinement", min_length=1
    )

    plots: list[PlotFile] = optional("plots of the study's own points", min_length=1)
    pages: bool = Field(
        False, description="a page on each point, linked by the report: what came out, pictures"
    )
    decide: DecideFile = optional(
        "what more replicates and longer runs are to decide, and at what cost"
    )
    plugins: list[
        Annotated[str, Field(pattern=PATTERN, json_schema_extra={"allowed": ALLOWED})]
    ] = optional(
        "code that the study runs with: Python files in the same folder, and names of installed "
        "plug-ins (docs/extending.md)",
        min_length=1,
    )
    parts: list[
        # A lone hyphen would be standard input.
        Annotated[
            str,
            Field(
                pattern=r"^([^/\\-]|[^/\\]{2,})$", json_schema_extra={"allowed": "a file's name"}
            ),
        ]
    ] = optional(
        "study files in the same folder whose points, boundaries and figures this one has too",
        min_length=1,
    )

    @model_validator(mode="after")
    def _of_a_name_of_its_own(self) -> Self:
        if self.study in _RESERVED:
            allowed = f"a name other than {', '.join(_RESERVED)}, where published studies lie"
            raise broken_rule("study", self.study, allowed)
        require_shown(self.title)
        return self

    @model_validator(mode="after")
    def _of_some_points(self) -> Self:
        if not self.series and not self.boundaries and not self.parts:
            raise broken_rule("series", None, "at least one series, boundaries, or parts")
        return self


class FileModels(NamedTuple):
    """What study files may contain: of each system, under keys of all, and the whole."""

    systems: dict[str, Models]
    defaults: type[Strict]
    readings: type[Strict]
    study: type[StudyFile]


def file_models() -> FileModels:
    """Return what study files may contain with the parameters that plug-ins have added by now."""
    return _file_models(tuple(SYSTEMS.values()))


@cache
def _file_models(parameters: tuple[type[Parameters], ...]) -> FileModels:
    """Return those of the present `SYSTEMS`, which ``parameters`` are."""
    systems = {system: _models_of(system) for system in SYSTEMS}
    defaults = create_model(
        "Defaults",
        __base__=Strict,
        __doc__="Parameters shared by all series of a system.",
        **_by_system(systems, "some", "shared by all series of the {}"),
    )
    readings = create_model(
        "SharedReadings",
        __base__=Strict,
        __doc__="Readings of the papers under which all series of a system are run.",
        **_by_system(
            systems,
            "readings",
            "of the {}: every combination; figures and boundaries take the first",
        ),
    )
    said = StudyFile.model_fields
    types: dict[str, Any] = {
        "defaults": (defaults, Field(defaults(), description=said["defaults"].description)),
        "readings": (readings, Field(readings(), description=said["readings"].description)),
        "series": (_list_of(_any_of(one.series for one in systems.values())), said["series"]),
        "boundaries": (
            _list_of(_any_of(one.boundary for one in systems.values())),
            said["boundaries"],
        ),
    }
    doc = "A study: series of points, boundaries to be found, and the figures they feed."
    study = create_model("StudyFile", __base__=StudyFile, __doc__=doc, **types)
    return FileModels(systems, defaults, readings, study)


def validated(mapping: Any, source: str) -> StudyFile:
    """Validate the contents of a study file; the points themselves come later.

    Raises
    ------
    InputError
        Naming file, key, value and what is allowed.
    """
    model = file_models().study
    try:
        return model.model_validate(mapping)
    except ValidationError as error:
        raise input_error(error, model, source) from None
