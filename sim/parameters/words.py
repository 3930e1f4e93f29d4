"""Parameters in SI and in words."""

import re
from collections.abc import Sequence
from typing import Any

from sim.parameters.common import Parameters
from sim.parameters.in_place import Quantity, scales
from sim.parameters.points import SYSTEMS, complete_values, field_info

#: The protocols in words, by system. Walton gives no lengths of runs, so the fixed length is ours.
PROTOCOLS = {
    "chute": {"published": "fixed length", "converged": "converged"},
    "belt": {"published": "published protocol", "converged": "converged protocol"},
    "conveyor": {"published": "fixed length", "converged": "converged"},
    "function": {"published": "one call"},
}

#: A letter, or a difference, with a subscript.
SUBSCRIPT = re.compile(r"(?<![\w$])(Δ?[^\W\d_])_([^\W_]+)(?![\w$])")

#: Longest name that is written in full, and how many last characters of a longer one are written.
LONG, END = 54, 16


def quantity(system: str, name: str, values: Sequence[Any]) -> str:
    """Return ``symbol = value unit`` for one or several values of a parameter.

    Without a symbol the name is used.

    >>> quantity("belt", "frequency", [20.0, 50.0])
    'f = 20, 50 Hz'
    >>> quantity("belt", "corrections", [2])
    'corrections = 2'
    >>> quantity("chute", "stiffness", [1e4])
    'K1 = 10,000 N/m'
    """
    row = field_info(SYSTEMS[system])[name]
    numbers = ", ".join(map(_number, sorted(set(values))))
    scale = "g" if row.scale == "g" else f" {row.scale}" if row.scale else ""
    return f"{row.symbol or name} = {numbers}{row.unit_text}{scale}"


def _number(value: float) -> str:
    """Return a number with four digits, or six from 10,000 on; no exponent below a million."""
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.6g}"


def setting(system: str, name: str, value: object) -> str:
    """Return one value of a parameter in words: ``θ = 16°``, ``integrator verlet``.

    Datasets store booleans as numbers:

    >>> setting("conveyor", "rotation", 0.0), setting("chute", "stress_profiles", True)
    ('no rotation', 'stress_profiles')

    Of a long text, such as the id of a run, only the end is written.

    >>> run = "chute-depth5-friction0.4-restitution0.85-stiffness100-angle2-f9db71a0"
    >>> setting("chute", "start_from", ""), setting("chute", "start_from", run)
    ('no start_from', 'start_from …-angle2-f9db71a0')
    """
    if isinstance(value, bool) or SYSTEMS[system].model_fields[name].annotation is bool:
        return name if value else f"no {name}"
    if not isinstance(value, str):
        return quantity(system, name, [value])
    if not value:
        return f"no {name}"
    return f"{name} {value if len(value) <= LONG else '…' + value[-END:]}"


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
    known = scales(values) if parameters.is_flow else {}
    for name, row in field_info(parameters).items():
        if row.scale in known and isinstance(values[name], float):
            scale = known[row.scale]
            quantities[name] = Quantity(values[name] * scale.value, scale.unit)
        elif row.unit not in ("", "1"):
            quantities[name] = Quantity(values[name], row.unit)
    return quantities
