"""A point, one complete set of parameters: reading, validation, canonical form, id and amounts.

Amounts are how much of a point is run. They are no part of its id, so runs can grow.
"""

import hashlib
import json
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from sim.base.additions import on_change, plugin_options
from sim.base.errors import InputError
from sim.base.messages import add_synonym, allowed_values, input_error, names_meant, one_of
from sim.base.numbers import plain
from sim.base.plugins import load_shipped
from sim.base.yaml import read_yaml
from sim.parameters.belt import BeltParameters
from sim.parameters.choices import extended
from sim.parameters.chute import ChuteParameters
from sim.parameters.common import Parameters, canonical_number, given_sizes
from sim.parameters.conveyor import ConveyorParameters
from sim.parameters.doubts import doubts
from sim.parameters.given import require_possible, state_of, with_state
from sim.parameters.in_place import given_by, plain_values
from sim.parameters.laws import ENGINE, FUNCTION, LAW, MOTION, FunctionParameters
from sim.parameters.roles import (
    Declaration,
    added_parameters,
    amount_parameters,
    declarations,
    fixed_parameters,
    id_parts,
    numerical_parameters,
)

#: Words for names that are no parameters: keys, kinds and observables of plots.
SYNONYMS = {
    "colour": "c color hue value values z",
    "curves": "by hue line lines plot",
    "distribution": "hist histogram",
    "map": "contour heat_map heatmap phase_diagram",
    "panels": "col facet facets row subplots",
    "profiles": "profile",
    "time_series": "series timeseries",
    "mass_flux": "flow_rate throughput",
    "velocity": "mean_velocity speed v",
}

SYSTEMS: dict[str, type[Parameters]] = {
    "chute": ChuteParameters,
    "belt": BeltParameters,
    "conveyor": ConveyorParameters,
}


def _update_systems() -> None:
    SYSTEMS.update(
        chute=extended(ChuteParameters, LAW, ENGINE),
        belt=extended(BeltParameters, MOTION),
        conveyor=extended(ConveyorParameters, LAW, MOTION, ENGINE),
    )
    SYSTEMS.pop(FUNCTION.name, None)
    if plugin_options(FUNCTION.name):
        SYSTEMS[FUNCTION.name] = extended(FunctionParameters, FUNCTION)
    for model in SYSTEMS.values():
        for name, declaration in declarations(model).items():
            add_synonym(declaration.symbol, name)
    for name, words in sorted(all_synonyms().items()):
        for word in words.split():
            add_synonym(word, name)


def all_synonyms() -> dict[str, str]:
    """Return the words for parameters and for other names, by name."""
    declared = [one for model in SYSTEMS.values() for one in declarations(model).items()]
    return {name: one.synonyms for name, one in declared if one.synonyms} | SYNONYMS


load_shipped("sim.laws")
load_shipped("sim.laws.motions")
load_shipped("sim.engines")
LAW.describe()
ENGINE.describe()
on_change(_update_systems)

#: Suffix of run files.
RUN_FILE = ".nc"

#: Longest readable part of an id; file systems allow 255 bytes for the whole file name.
ID_LENGTH = 160

#: Parameters of all systems that set how a flow is computed, not which flow it is; and that set how
#: much of a point is run.
NUMERICAL = frozenset().union(*map(numerical_parameters, SYSTEMS.values()))
AMOUNTS = frozenset().union(*map(amount_parameters, SYSTEMS.values()))

#: Amounts whose smaller value asks for more; and those without effect under the published protocol,
#: whose runs end after transient and average.
_FINER, _CONVERGED_ONLY = ("target",), ("limit",)


def parse_point(
    mapping: Any, source: str | Path, paths: Mapping[str, str] | None = None
) -> Parameters:
    """Return the parameters of one point: complete, canonical and immutable.

    ``mapping`` has ``system`` and any of its parameters, or keys in their place; numbers may have a
    unit (``2 mm``). Omitted ones take the paper's values, and a given initial state gives the
    number of particles. Raises ``InputError``, which names ``source`` and the path of a value
    there, the parameter itself or that of ``paths``.
    """
    if not isinstance(mapping, Mapping):
        raise InputError.of_value(source, "", mapping, "a mapping of parameter names to values")
    system = mapping.get("system")
    if not isinstance(system, str) or system not in SYSTEMS:
        path = (paths or {}).get("system", "system")
        raise InputError.of_value(source, path, system, one_of(system, SYSTEMS))
    model, paths = SYSTEMS[system], paths or {}
    plain = plain_values(mapping, model, str(source), paths)
    values = with_state(plain, model, str(source), paths)
    for key in model.in_place.keys() & mapping.keys():
        paths = {**dict.fromkeys(given_by(model, key), paths.get(key, key)), **paths}
    try:
        point = model.model_validate(values)
        # The least sizes of particles follow from the state, whose table has no other units.
        if point.initial_state and (state := require_possible(point)) != point.initial_state:
            point = model.model_validate({**values, "initial_state": state})
        return point
    except ValidationError as error:
        hint = partial(hint_on_key, system=system)
        raise input_error(error, model, str(source), paths, hint) from None


def hint_on_key(key: str, system: str) -> str:
    """Return how a parameter follows from what a key names, or whose parameter it is.

    The text is empty if the key may mean a parameter of the system.
    """
    names = {one: {*model.model_fields, *model.in_place} for one, model in SYSTEMS.items()}
    every, own = set[str]().union(*names.values()), names[system]
    found = [] if key in own else [(one, _followed(key, one)) for one in (system, *SYSTEMS)]
    where, (name, formula) = next((one for one in found if one[1][0]), ("", ("", "")))
    if where == system:
        return f"give {name}: {formula}"
    meant = [name] if name else names_meant(key, every)
    if key in own or (key not in every and (not meant or not own.isdisjoint(meant))):
        return ""
    name = key if key in every else meant[0]
    owners = [one for one, known in names.items() if name in known]
    question = "" if formula or name == key else f"did you mean {name}? "
    return f"{question}{name} is a parameter of the {' and the '.join(owners)}"


def _followed(key: str, system: str) -> tuple[str, str]:
    """Return a parameter of a system that follows from another quantity, and how; or two blanks."""
    for name, row in declarations(SYSTEMS[system]).items():
        for part in row.follows.split("; "):
            words, _, formula = part.partition(": ")
            if key.lower() in words.split():
                return name, formula
    return "", ""


def parse_python_point(source: str, system: Any, values: Mapping[str, Any]) -> Parameters:
    """Validate a point as `parse_point` does; the values may be numbers of NumPy.

    Sizes of particles that are probably not meant are a warning.
    """
    given = plain(values)
    fields = SYSTEMS[system].model_fields if system in SYSTEMS else {}
    for name in fields.keys() & given.keys() - SYSTEMS["chute"].pairs:
        is_number, value = fields[name].annotation in (int, float), given[name]
        if is_number and hasattr(value, "__len__") and not isinstance(value, str):
            allowed = f"{allowed_values(fields[name])}; for several, a loop or a study with a grid"
            raise InputError.of_value(source, name, value, allowed)
    point = parse_point({**given, "system": system}, source)
    for _, text in doubts(point):
        # As the caller of `simulate` or `Flow` sees it.
        warnings.warn(text, stacklevel=3)
    return point


def load_point(path: str | Path) -> Parameters:
    """Read a point from a YAML (or JSON) file, or from standard input when ``path`` is ``-``."""
    return parse_point(read_yaml(path), "<stdin>" if str(path) == "-" else path)


def canonical_values(parameters: Parameters) -> dict[str, Any]:
    """Return the parameters, ``system`` included, as plain JSON values for ids and files.

    Added parameters (see `sim.parameters.roles.declare`) with their default are omitted.
    ``parse_point`` of the result gives an equal point.
    """
    model, values = type(parameters), complete_values(parameters)
    added = added_parameters(model)
    unused = {name for name in added if values[name] == default_of(model, name, values)}
    return {name: value for name, value in values.items() if name not in unused}


def complete_values(parameters: Parameters) -> dict[str, Any]:
    """Return every parameter, ``system`` included, as plain JSON values."""
    return parameters.model_dump(mode="json")


def canonical_json(parameters: Parameters) -> str:
    """Return the canonical form as one line of JSON with sorted keys."""
    return _json(canonical_values(parameters))


def _json(values: Mapping[str, Any]) -> str:
    return json.dumps(values, sort_keys=True, separators=(",", ":"))


def point_id(parameters: Parameters) -> str:
    """Return the id of a point: a readable form, then eight hexadecimal digits of its hash.

    The readable form has the parameters that the figures vary most, and those others that differ
    from the paper and are not numerical. The id depends only on the parameters, all but the
    amounts, so equal points have equal ids. It is fit for a file name:

    >>> point_id(ChuteParameters())[:46]
    'chute-depth5-friction0.4-restitution0.85-stiff'
    """
    values, model = canonical_values(parameters), type(parameters)
    parts = id_parts(model)
    shown = {name: label for name, label in parts.items() if name not in parameters.replaced}
    readable = [f"{label}{values[name]:g}" for name, label in shown.items()]
    unnamed = numerical_parameters(model) | set(parts)
    for name, value in values.items():
        if name not in unnamed and value != default_of(model, name, values):
            readable.append(f"{name}-{value}" if isinstance(value, str) else f"{name}{value:g}")
    name = "-".join([parameters.system, *readable]).replace("+", "")
    # A schedule has spaces and colons.
    name = re.sub(r"[ :;]+", "-", name)[:ID_LENGTH]
    wanted = amount_parameters(model)
    usual = {one: type(values[one])(default_of(model, one, values)) for one in wanted}
    return f"{name}-{hashlib.sha256(_json(values | usual).encode()).hexdigest()[:8]}"


def amounts(parameters: Parameters) -> dict[str, float]:
    """Return the amounts of a point that have an effect, by parameter."""
    excluded = _CONVERGED_ONLY if parameters.protocol == "published" else ()
    names = amount_parameters(type(parameters))
    return {name: getattr(parameters, name) for name in names if name not in excluded}


def covers(available: Mapping[str, float], needed: Mapping[str, float]) -> bool:
    """True where the available amounts of a point are at least the needed ones."""
    pairs = needed.items()
    return all(_larger(name, available[name], value) == available[name] for name, value in pairs)


def with_larger_amounts(parameters: Parameters, available: Mapping[str, float]) -> Parameters:
    """Return a point with the larger of its own and the available value of each amount."""
    larger = {
        name: type(value)(_larger(name, available.get(name, value), value))
        for name, value in amounts(parameters).items()
    }
    return parameters.model_copy(update=larger)


def _larger(name: str, first: float, second: float) -> float:
    return min(first, second) if name in _FINER else max(first, second)


def default_of(model: type[Parameters], name: str, values: Mapping[str, Any]) -> Any:
    """Return the default of a parameter, which may depend on other parameters in ``values``."""
    field = model.model_fields[name]
    given = field.get_default(call_default_factory=True, validated_data=dict(values))
    return canonical_number(given)


def defaults_of_added(system: str) -> dict[str, Any]:
    """Return the defaults of a system's added parameters, which older files do not have."""
    model = SYSTEMS[system]
    return {name: model.model_fields[name].default for name in added_parameters(model)}


def require_compatible_source(parameters: Parameters, source: Parameters, where: str) -> None:
    """Raise ``InputError``, naming ``where``, unless a point can start from a run of another one.

    That is of the same system and `fixed_parameters`, and has as many replicates.
    """
    allowed = ""
    if source.system != parameters.system:
        allowed = f"a run of the {parameters.system}"
    elif given_sizes(source) != given_sizes(parameters):
        allowed = "a run of particles that all have the mass and the diameter of the point"
    elif source.replicates < parameters.replicates:
        allowed = f"a run of {parameters.replicates} replicates or more, as of the point itself"
    else:
        for name in fixed_parameters(type(parameters)):
            value, source_value = getattr(parameters, name), getattr(source, name)
            if source_value != value:
                allowed = f"a run with {name} = {value}, as of the point itself, not {source_value}"
    if allowed:
        raise InputError.of_value(where, "start_from", parameters.start_from, allowed)


@dataclass(frozen=True, kw_only=True)
class FieldRow(Declaration):
    """One parameter, ready for documentation and file attributes.

    ``allowed`` is never empty; ``default`` is ``None`` when it depends on other parameters.
    """

    name: str
    description: str
    default: Any


def field_info(model: type[Parameters] | Parameters) -> Mapping[str, FieldRow]:
    """Return the declaration of every parameter of a system by name.

    ``system`` comes first, then this system's own parameters, then those of all systems.
    """
    return _rows(model if isinstance(model, type) else type(model))


@cache
def _rows(model: type[Parameters]) -> Mapping[str, FieldRow]:
    declared = declarations(model)
    rows = {
        name: FieldRow(
            name=name,
            description=field.description or "",
            default=None if field.default_factory else field.default,
            **vars(declared[name]) | {"allowed": allowed_values(field)},
        )
        for name, field in model.model_fields.items()
    }
    order = {"system": 0} | dict.fromkeys(Parameters.model_fields, 2)
    return MappingProxyType(dict(sorted(rows.items(), key=lambda row: order.get(row[0], 1))))


def as_yaml(parameters: Parameters) -> str:
    """Return the text of a point file with every parameter."""
    values = complete_values(parameters)
    if state := state_of(parameters):
        values["initial_state"] = state.text
    # JSON scalars are YAML with the same value.
    return "".join(f"{name}: {json.dumps(values[name])}\n" for name in field_info(parameters))
