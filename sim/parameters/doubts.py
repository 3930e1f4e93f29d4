"""Values of parameters that are probably not meant, though they are allowed."""

from collections.abc import Iterator, Sequence
from math import atan2, degrees, pi

from sim.base.errors import count_text
from sim.parameters.common import Parameters
from sim.parameters.roles import declarations

#: Least and largest density (kg/m³) of what flows in one piece: aerogel to osmium.
LEAST, LARGEST = 100.0, 25_000.0

#: Largest length (m) that is not taken for one in another unit, or in units without dimension.
LARGEST_LENGTH = 0.1


def doubts_of(points: Sequence[Parameters]) -> list[str]:
    """Return a warning for each parameter that is doubtful at some points: that of the first.

    An angle is doubtful only where it is small at all points.
    """
    texts: dict[str, list[str]] = {}
    for point in points:
        for name, text in doubts(point):
            texts.setdefault(name, []).append(text)
    for name in list(texts):
        row = declarations(type(points[0])).get(name)
        if row and row.unit == "degree" and any(getattr(one, name, 0) > pi / 2 for one in points):
            del texts[name]
    return [f"at {count_text(len(each), 'point')}: {each[0]}" for each in texts.values()]


def doubts(point: Parameters) -> Iterator[tuple[str, str]]:
    """Yield what is probably not meant of a point: a parameter, and a warning in words.

    Where the diameter is another than that of the paper's particles, so are their mass and, in N/m,
    their stiffness. Flows in units of diameter, mass and gravity have no such sizes.
    """
    if not point.is_flow or point.diameter == point.mass == point.gravity == 1:
        return
    fields = type(point).model_fields
    units = {name: row.unit for name, row in declarations(type(point)).items()}
    values = {name: getattr(point, name) for name in units}
    if "amplitude_along" in values:
        direction = degrees(atan2(values["amplitude"], values["amplitude_along"]))
        values, units = (
            values | {"vibration_angle": direction},
            units | {"vibration_angle": "degree"},
        )
    for name, unit in units.items():
        value = values[name]
        if unit == "degree" and 0 < value <= pi / 2:
            right = f"{value:g}°; if you mean radians, write {degrees(value):.4g}"
            yield name, f"{name}: {value:g} is {right}"
        elif unit == "m" and value > LARGEST_LENGTH:
            right = f"{value:g} m; if you mean {value:g} mm, write {value / 1000:g}"
            yield name, f"{name}: {value:g} is {right}"
    if point.diameter > LARGEST_LENGTH:
        return
    usual, stiffness = fields["diameter"].default, fields["stiffness"]
    is_other, rho = point.diameter != usual, point.density
    size, paper = f"diameter {point.diameter:g} m with", f"of the paper's particles of {usual:g} m"
    density = f"a density of {rho:.3g} kg/m³"
    if is_other and point.mass == fields["mass"].default:
        text = f"{size} the mass {paper}, {point.mass:g} kg, is {density}; give density or mass"
        yield "mass", text
    elif not LEAST <= rho <= LARGEST:
        text = f"{size} mass {point.mass:g} kg is {density}; usual are {LEAST:g} to {LARGEST:,g}"
        if LEAST <= rho / 1000 <= LARGEST:
            text += f"; if you mean {point.mass:g} g, write {point.mass / 1000:g}"
        yield "mass", text
    is_absolute = getattr(stiffness.json_schema_extra, "unit", "") == "N m-1"
    is_left = point.stiffness == stiffness.default and "stiffness" not in point.replaced
    if is_other and is_absolute and is_left:
        # At the same stiffness in units of mg/σ, they overlap by the same share of their diameter.
        hard = usual * point.mass * point.gravity / point.diameter / fields["mass"].default
        hard *= stiffness.default / fields["gravity"].default
        text = f"{size} the stiffness {paper}, {point.stiffness:g} N/m"
        text += f"; for them {hard:.2g} N/m is as hard" if hard > point.stiffness else ""
        yield "stiffness", text
