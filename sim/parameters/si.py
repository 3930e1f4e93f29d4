"""Parameters in SI: pure numbers of a study file, multiplied by their scales."""

from typing import NamedTuple

from sim.parameters.common import Parameters
from sim.parameters.points import complete_values, field_info


class Quantity(NamedTuple):
    """A value and its unit as UDUNITS reads it."""

    value: float
    unit: str


def in_si(parameters: Parameters) -> dict[str, Quantity]:
    """Return the parameters of a point that have a dimension, in SI, by name.

    Multiples of a length, time, rate, velocity or stiffness of the point are multiplied by it. The
    others have their declared unit: angles stay in degrees. Pure numbers and counts are omitted.

    >>> from sim.parameters.belt import BeltParameters
    >>> quantities = in_si(BeltParameters(amplitude=2, frequency=20))
    >>> quantities["amplitude"], quantities["transient"]
    (Quantity(value=0.002, unit='m'), Quantity(value=2.25, unit='s'))
    """
    values, quantities = complete_values(parameters), {}
    scales = _scales(parameters)
    for name, row in field_info(parameters).items():
        if row.scale in scales and isinstance(values[name], float):
            scale = scales[row.scale]
            quantities[name] = Quantity(values[name] * scale.value, scale.unit)
        elif row.unit not in ("", "1"):
            quantities[name] = Quantity(values[name], row.unit)
    return quantities


def _scales(p: Parameters) -> dict[str, Quantity]:
    """Return the quantities of which numbers are multiples, by ``scale`` of their declaration.

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
