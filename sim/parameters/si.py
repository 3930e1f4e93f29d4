"""Parameters in SI: what a pure number of a study file is a multiple of."""

from typing import NamedTuple

from sim.parameters.common import Parameters
from sim.parameters.points import complete, field_info


class Quantity(NamedTuple):
    """A value and its unit as UDUNITS reads it."""

    value: float
    unit: str


def in_si(parameters: Parameters) -> dict[str, Quantity]:
    """Return the parameters of a point that have a dimension, in SI, by name.

    Those that are multiples of a length, time, velocity or stiffness of the point are multiplied;
    the others have the unit in which they are declared. Angles stay in degrees; counts are none.

    >>> from sim.parameters.belt import BeltParameters
    >>> found = in_si(BeltParameters(amplitude=2, frequency=20))
    >>> found["amplitude"], found["transient"]
    (Quantity(value=0.002, unit='m'), Quantity(value=2.25, unit='s'))
    """
    values, found = complete(parameters), {}
    scales = _scales(parameters)
    for name, row in field_info(parameters).items():
        if row.scale in scales and isinstance(values[name], float):
            scale = scales[row.scale]
            found[name] = Quantity(values[name] * scale.value, scale.unit)
        elif row.unit not in ("", "1"):
            found[name] = Quantity(values[name], row.unit)
    return found


def _scales(p: Parameters) -> dict[str, Quantity]:
    """Return what numbers are multiples of, as their declarations write it.

    An overlap relative to the radii of a pair has no unit.
    """
    length, velocity = Quantity(p.diameter, "m"), Quantity(p.velocity_unit, "m s-1")
    time = Quantity(p.time_unit, "s")
    return {
        "σ": length,
        "⟨d⟩": length,
        "√(gσ)": velocity,
        "√(g⟨d⟩)": velocity,
        "√(σ/g)": time,
        "cycles": time,
        # A rate: 50 means 500 per second where gravity is 10 m s-2.
        "g": Quantity(p.gravity, "s-1"),
        "g⟨m⟩/⟨d⟩": Quantity(p.gravity * p.mass / p.diameter, "N m-1"),
    }
