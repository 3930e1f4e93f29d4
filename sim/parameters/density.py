"""A density in place of the mass, and sizes of particles that are probably not meant."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic.fields import FieldInfo

from sim.base.errors import InputError, count_text
from sim.parameters.common import Parameters, Real, sphere_volume
from sim.parameters.roles import declare

#: Key that stands in place of the mass in files and calls; points, and so their ids, have the mass.
DENSITY = "density"


#: Declaration of the density for models of study files.
DENSITY_FIELD = FieldInfo.from_annotated_attribute(
    Real,
    declare(0, unit="kg m-3", description="density of the particles, in place of mass", gt=0),
)

#: Least and largest density (kg/m³) of what flows in one piece: aerogel to osmium.
LEAST, LARGEST = 100.0, 25_000.0

#: Largest diameter (m) that is not taken for one in another unit, or in units without dimension.
LARGEST_DIAMETER = 0.1


def with_mass(
    values: Mapping[str, Any], model: type[Parameters], source: str, paths: Mapping[str, str]
) -> dict[str, Any]:
    """Return values of parameters with the mass that a density among them gives."""
    if DENSITY not in values:
        return dict(values)
    rest = {name: value for name, value in values.items() if name != DENSITY}
    given, path = values[DENSITY], paths.get(DENSITY, DENSITY)
    if "mass" in rest:
        raise InputError.of_value(source, path, given, "density or mass, not both")
    if type(given) not in (int, float) or not 0 < given < 1e15:
        raise InputError.of_value(source, path, given, "a number > 0, in kg/m³, without the unit")
    if "diameter" not in model.model_fields:
        raise InputError.of_value(source, path, given, "none: the system has no particles")
    diameter = rest.get("diameter", model.model_fields["diameter"].default)
    # Another diameter is refused by the model.
    is_usable = type(diameter) in (int, float) and 0 < diameter < 1e15
    return rest | {"mass": float(given) * sphere_volume(diameter)} if is_usable else rest


def doubts_of(points: Iterable[Parameters]) -> list[str]:
    """Return a warning for each parameter that is doubtful at some points: that of the first."""
    texts: dict[str, list[str]] = {}
    for point in points:
        for name, text in doubts(point):
            texts.setdefault(name, []).append(text)
    return [f"at {count_text(len(each), 'point')}: {each[0]}" for each in texts.values()]


def doubts(point: Parameters) -> Iterator[tuple[str, str]]:
    """Yield what is probably not meant of the particles: a parameter, and a warning in words.

    Where the diameter is another than that of the paper's particles, so are their mass and, in N/m,
    their stiffness. A dimensionless study has no such sizes.
    """
    fields = type(point).model_fields
    if "diameter" not in fields:
        return
    usual, stiffness = fields["diameter"].default, fields["stiffness"]
    is_other, rho = point.diameter != usual, point.density
    if point.diameter > LARGEST_DIAMETER:
        return
    size, paper = f"diameter {point.diameter:g} m with", f"of the paper's particles of {usual:g} m"
    density = f"a density of {rho:.3g} kg/m³"
    if is_other and point.mass == fields["mass"].default:
        text = f"{size} the mass {paper}, {point.mass:g} kg, is {density}; give density or mass"
        yield "mass", text
    elif not LEAST <= rho <= LARGEST:
        text = f"{size} mass {point.mass:g} kg is {density}; usual are {LEAST:g} to {LARGEST:,g}"
        yield "mass", text
    is_absolute = getattr(stiffness.json_schema_extra, "unit", "") == "N m-1"
    is_left = point.stiffness == stiffness.default and "stiffness" not in point.replaced
    if is_other and is_absolute and is_left:
        text = f"{size} the stiffness {paper}, {point.stiffness:g} N/m; look at their overlap"
        yield "stiffness", text
