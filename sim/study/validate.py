"""Second step of a study: validate what was read by the models of its systems and figures."""

from collections.abc import Collection, Sequence
from functools import cache, partial, reduce
from operator import or_
from pathlib import Path
from types import GenericAlias
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    TypeAdapter,
    WithJsonSchema,
    WrapValidator,
    create_model,
)

from sim.base.errors import InputError
from sim.parameters import AMOUNTS, SYSTEMS, Parameters, roles
from sim.study.design_file import SPREAD, DesignFile, Distribution, Over, read_values
from sim.study.entries import (
    Lists,
    Override,
    Readings,
    Some,
    Strict,
    allow_range_in_schema,
    expand_range,
    number_or_text,
    one_or_pair,
    optional,
    read_into,
)
from sim.study.figure_spec import FIGURES
from sim.study.file import BoundaryFile, SeriesFile, StudyFile

#: What models of a system say of themselves.
_DOCS: dict[type[BaseModel], str] = {
    Override: "Parameters of the {} that change at the points where others have certain values.",
    DesignFile: "Points of the {} that are spread over ranges of parameters.",
    SeriesFile: (
        "A series of points of the {}. Without grid, cases and design, the base is its one point."
    ),
    BoundaryFile: "A boundary between regimes of the {}, for each combination of the grid.",
}

#: Type of the key ``figures`` of a system that feeds no figure.
_NO_FIGURES = Annotated[list[str], Field(max_length=0)]


class SystemModels(NamedTuple):
    """Models of the parts of a study file that concern one system."""

    parameters: type[Some]
    readings: type[Lists]
    override: type[Override]
    series: type[SeriesFile]
    boundary: type[BoundaryFile] | None


def _system_models(system: str) -> SystemModels:
    model = SYSTEMS[system]
    # No boundary is along a parameter that flows do not depend on, such as the length of a run.
    excluded = roles.numerical_parameters(model) - set(roles.start_parameters(model))
    floats = (name for name, field in model.model_fields.items() if field.annotation is float)
    numbers = tuple(name for name in floats if name not in excluded)
    figures = [name for name, spec in FIGURES.items() if spec.system == system]
    values, lists = _with_parameters(Some, system), _with_parameters(Lists, system)
    readings = _with_parameters(Readings, system, roles.reading_parameters(model))
    over = _with_parameters(Over, system, {*SPREAD, *model.model_fields} - AMOUNTS)
    override = _of_system(Override, system, when=lists, set=values)
    shared: dict[str, Any] = {
        "system": Literal[system],
        "base": values,
        "grid": lists,
        "overrides": _list_type(override),
        "figures": _list_type(Literal[tuple(figures)]) if figures else _NO_FIGURES,
    }
    design = _of_system(DesignFile, system, over=over)
    shown = shared | {"cases": _list_type(values), "design": design}
    series = _of_system(SeriesFile, system, **shown)
    boundary = None
    if model.boundaries:
        what = {"of": Literal[model.boundaries], "along": Literal[numbers]}
        boundary = _of_system(BoundaryFile, system, **shared, **what)
    return SystemModels(values, readings, override, series, boundary)


def _with_parameters(base: type[Some], system: str, names: Collection[str] | None = None) -> Any:
    """Return a model based on ``base`` with all parameters of a system, or some, as fields."""
    fields: dict[str, Any] = {}
    parameters = SYSTEMS[system]
    for key, parameter in (parameters.model_fields | parameters.in_place).items():
        if key == "system" or (names is not None and key not in names):
            continue
        value: Any = Annotated[(parameter.annotation, *parameter.metadata, None)]
        said: str | None = parameter.description
        row: Any = parameter.json_schema_extra
        field = optional(said)
        if parameter.annotation is float:
            value = Annotated[value, WrapValidator(partial(number_or_text, row=row))]
        if key in parameters.pairs and not issubclass(base, Lists):
            one = TypeAdapter(value).json_schema()
            pair = {"type": "array", "items": one, "minItems": 2, "maxItems": 2}
            said_of_both = WithJsonSchema({"anyOf": [one, pair]})
            value = Annotated[value, WrapValidator(one_or_pair), said_of_both]
        if issubclass(base, Lists):
            value = Annotated[_list_type(value), Field(min_length=1)]
            if issubclass(base, Over):
                read = partial(read_values, row=row)
                value = Annotated[list[Any] | Distribution, BeforeValidator(read)]
            elif parameter.annotation in (int, float):
                expand = partial(expand_range, are_whole=parameter.annotation is int)
                value = Annotated[value, BeforeValidator(expand)]
                field = Field(None, description=said, json_schema_extra=allow_range_in_schema)
        fields[key] = value, field
    name = f"{system.capitalize()}{base.__name__}"
    model = create_model(name, __base__=base, __doc__=base.__doc__, **fields)
    model.parameters, model.in_place = parameters, parameters.in_place
    return model


def _of_system(base: type[BaseModel], system: str, /, **types: Any) -> Any:
    """Return a model based on ``base`` whose fields have the types of a system."""
    fields: dict[str, Any] = {one: (kind, base.model_fields[one]) for one, kind in types.items()}
    name = f"{system.capitalize()}{base.__name__.removesuffix('File')}"
    made: Any = create_model(name, __base__=base, __doc__=_DOCS[base].format(system), **fields)
    return made


def _list_type(kind: Any) -> Any:
    return GenericAlias(list, (kind,))


def file_models() -> tuple[type[StudyFile], dict[str, SystemModels]]:
    """Return the models of study files and of their parts, with what plug-ins have added so far."""
    return _build_file_models(tuple(SYSTEMS.values()), tuple(FIGURES))


@cache
def _build_file_models(
    parameters: tuple[type[Parameters], ...], figures: tuple[str, ...]
) -> tuple[type[StudyFile], dict[str, SystemModels]]:
    """Return the models for the present `SYSTEMS` and `FIGURES`: the key of the cache."""
    systems = {system: _system_models(system) for system in SYSTEMS}

    def of_systems(name: str, key: str, kind: str, doc: str, description: str) -> Any:
        """Return the declaration of a key with a part for each system, all optional."""
        parts: dict[str, Any] = {
            system: (getattr(models, kind), optional(description.format(system)))
            for system, models in systems.items()
        }
        model = create_model(name, __base__=Strict, __doc__=doc, **parts)
        return model, Field(model(), description=StudyFile.model_fields[key].description)

    def list_of(kind: str) -> Any:
        models = reduce(or_, filter(None, (getattr(one, kind) for one in systems.values())))
        return _list_type(Annotated[models, Field(discriminator="system")])

    fields, shared = StudyFile.model_fields, "shared by all series of the {}"
    values = "Parameters shared by all series of a system."
    readings = "Readings of the papers under which all series of a system are run."
    each = "of the {}: every combination; figures and boundaries take the first"
    types: dict[str, Any] = {
        "figures": (_list_type(Literal[figures]), fields["figures"]),
        "defaults": of_systems("Defaults", "defaults", "parameters", values, shared),
        "readings": of_systems("SharedReadings", "readings", "readings", readings, each),
        "series": (list_of("series"), fields["series"]),
        "boundaries": (list_of("boundary"), fields["boundaries"]),
    }
    doc = "A study: series of points, boundaries to be found, and the figures they feed."
    return create_model("StudyFile", __base__=StudyFile, __doc__=doc, **types), systems


def validate(documents: Sequence[tuple[Path, Any]]) -> list[tuple[Path, StudyFile]]:
    """Return the path and the model of each file of a study.

    Raises ``InputError`` for a wrong key or value, also if two files have a series of the same
    name, or a part has parts of its own.
    """
    (source, _), *parts = documents
    for index, (path, contents) in enumerate(parts):
        if isinstance(contents, dict) and "parts" in contents:
            allowed = "a study without parts of its own"
            raise InputError.of_value(source, f"parts[{index}]", path.name, allowed)
    (model, _), files, names = file_models(), list[tuple[Path, StudyFile]](), set[str]()
    for number, (path, contents) in enumerate(documents):
        files.append((path, read_into(model, contents, str(path))))
        for _, entry in files[-1][1].entries:
            if entry.name in names:
                key = f"parts[{number - 1}]: series {entry.name}"
                allowed = "a part without a series of a name that another has"
                raise InputError.of_value(source, key, path.name, allowed)
            names.add(entry.name)
    return files
