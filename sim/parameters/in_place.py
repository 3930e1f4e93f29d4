"""Values as people give them: numbers with a unit, and keys that stand in place of parameters.

Points, and so their ids, have plain numbers and parameters alone.
"""

from collections.abc import Mapping
from math import cos, radians, sin
from typing import Annotated, Any, NamedTuple

from pydantic import ConfigDict, TypeAdapter, ValidationError

from sim.base.errors import InputError
from sim.base.messages import allowed_number, conversion, number_and_unit
from sim.parameters.common import Parameters, canonical_number, sphere_volume
from sim.parameters.roles import Declaration, declarations

#: Keys in place of parameters, `Parameters.in_place`, and the parameters that they give.
GIVES = {
    "density": ("mass",),
    "stroke": ("amplitude", "amplitude_along"),
    "vibration_angle": ("amplitude_along",),
}

#: Angle of a stroke with the plane, degree, where none is given: that of the default amplitudes.
USUAL_ANGLE = 45.0

#: Parameters on which `scales` depend.
_SIZES = {"diameter", "gravity", "mass", "frequency"}

_STRICT = ConfigDict(strict=True, allow_inf_nan=False)


class Quantity(NamedTuple):
    """A value and its unit as UDUNITS reads it."""

    value: float
    unit: str


def given_by(model: type[Parameters], name: str) -> tuple[str, ...]:
    """Return the parameters of a system that a key gives: itself, or those that it stands for."""
    names = GIVES[name] if name in model.in_place else (name,)
    return tuple(one for one in names if one in model.model_fields)


def rivals(name: str) -> set[str]:
    """Return the keys that one replaces: what it gives, and what gives it."""
    return {key for key, names in GIVES.items() if name in names} | {*GIVES.get(name, ())}


def scales(values: Mapping[str, Any]) -> dict[str, Quantity]:
    """Return the quantities of which parameters are multiples, by ``scale`` of their declaration.

    ``values`` are those of a point in SI. An overlap relative to the radii of a pair has no unit.
    """
    length, gravity = values["diameter"], values["gravity"]
    velocity = Quantity((gravity * length) ** 0.5, "m s-1")
    known = {
        **dict.fromkeys(("σ", "⟨d⟩"), Quantity(length, "m")),
        **dict.fromkeys(("√(gσ)", "√(g⟨d⟩)"), velocity),
        "√(σ/g)": Quantity((length / gravity) ** 0.5, "s"),
        # A rate: 50 means 500 per second where gravity is 10 m s-2.
        "g": Quantity(gravity, "s-1"),
        "g⟨m⟩/⟨d⟩": Quantity(gravity * values["mass"] / length, "N m-1"),
    }
    if "frequency" in values:
        known["cycles"] = Quantity(1 / values["frequency"], "s")
    return known


#: Scales of some size, to ask whether a text has a unit of the kind of a parameter.
OF_UNIT_SIZE = scales(dict.fromkeys(_SIZES, 1.0))


def known_scales(values: Mapping[str, Any]) -> dict[str, Quantity]:
    """Return the `scales` of values, of which some may be missing or no sizes; none then."""
    sizes = {name: values[name] for name in _SIZES if name in values}
    is_whole = sizes.keys() >= _SIZES - {"frequency"} and all(map(_is_usable, sizes.values()))
    return scales(sizes) if is_whole else {}


def plain_number(value: Any, row: Declaration, known: Mapping[str, Quantity]) -> Any:
    """Return a text such as ``2 mm`` as a number in the unit of a parameter, ``row``.

    ``known`` are `scales`. Of a list each member counts. Any other value is returned as it is, and
    a text of a scale that is not known or of another kind.
    """
    if isinstance(value, list | tuple):
        return [plain_number(one, row, known) for one in value]
    if not (given := number_and_unit(value)):
        return value
    number, unit = given
    if row.scale and unit == row.scale:
        return canonical_number(number)
    size, to = known.get(row.scale, (1.0, "")) if row.scale else (1.0, row.unit)
    factor = conversion(unit, to) if to else None
    return value if factor is None else canonical_number(number * factor / size)


def plain_numbers(
    values: Mapping[str, Any], model: type[Parameters], known: Mapping[str, Quantity]
) -> dict[str, Any]:
    """Return values of parameters, each as `plain_number` does."""
    own: Any = {name: one.json_schema_extra for name, one in model.in_place.items()}
    rows = {**declarations(model), **own}
    return {
        name: plain_number(value, rows[name], known) if name in rows else value
        for name, value in values.items()
    }


def plain_values(
    values: Mapping[str, Any], model: type[Parameters], source: str, paths: Mapping[str, str]
) -> dict[str, Any]:
    """Return values of parameters as plain numbers, without keys in place of parameters.

    Raises ``InputError``, which names ``source`` and the path of a value there, for such a key
    beside what it gives, and for a value of it that is not allowed. Parameters are not checked.
    """
    plain = plain_numbers(values, model, {})
    for name in model.in_place.keys() & plain.keys():
        for other in rivals(name) & plain.keys():
            allowed = f"{name} or {other}, not both"
            raise InputError.of_value(source, paths.get(name, name), values[name], allowed)
    sizes = {name: model.model_fields[name].default for name in _SIZES & model.model_fields.keys()}
    sizes |= {name: plain[name] for name in sizes.keys() & plain.keys()}
    if "density" in plain and _is_usable(sizes["diameter"]):
        density = _checked("density", plain, model, source, paths)
        sizes["mass"] = plain["mass"] = density * sphere_volume(sizes["diameter"])
    # Sizes that are none are refused by the model.
    if known := known_scales(sizes):
        plain = plain_numbers(plain, model, known)
        if not plain.keys().isdisjoint(model.in_place.keys() - {"density"}):
            plain |= _amplitudes(plain, model, source, paths)
    return {name: value for name, value in plain.items() if name not in model.in_place}


def _is_usable(value: Any) -> bool:
    return type(value) in (int, float) and 0 < value < 1e15


def _checked(
    name: str,
    values: Mapping[str, Any],
    model: type[Parameters],
    source: str,
    paths: Mapping[str, str],
) -> float:
    """Return the value of a key in place of parameters, if it is in its range."""
    field, value = model.in_place[name], values[name]
    try:
        kind: Any = Annotated[(float, *field.metadata)]
        return float(TypeAdapter(kind, config=_STRICT).validate_python(value))
    except ValidationError:
        allowed = allowed_number(field, value)
        raise InputError.of_value(source, paths.get(name, name), value, allowed) from None


def _amplitudes(
    values: Mapping[str, Any], model: type[Parameters], source: str, paths: Mapping[str, str]
) -> dict[str, float]:
    """Return the amplitudes normal to the plane and along it of a stroke, and of a direction.

    A stroke is twice the amplitude along the line of motion.
    """
    keys = model.in_place.keys() & values.keys() - {"density"}
    own = {key: _checked(key, values, model, source, paths) for key in keys}
    angle = own.get("vibration_angle", values.get("vibration_angle", USUAL_ANGLE))
    amplitude = values.get("amplitude", model.model_fields["amplitude"].default)
    if not (_is_usable(angle) and (_is_usable(amplitude) or amplitude == 0)):
        return {}
    # To 15 digits the cosine of 90 degrees is 0.
    across, along = (round(one(radians(angle)), 15) for one in (sin, cos))
    if "stroke" in own:
        amplitude = 0.5 * own["stroke"] * across
    found = {"amplitude": amplitude, "amplitude_along": amplitude * along / across}
    return {name: found[name] for name in found if name in model.model_fields}
