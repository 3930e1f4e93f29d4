"""Parameters and their values in words."""

from collections.abc import Sequence
from typing import Any

from sim.parameters import SYSTEMS, field_info

#: The protocols in words, by system. Walton gives no lengths, so what is run once and no longer is
#: ours.
PROTOCOLS = {
    "chute": {"published": "fixed length", "converged": "converged"},
    "belt": {"published": "published protocol", "converged": "converged protocol"},
    "conveyor": {"published": "fixed length", "converged": "converged"},
}


def quantity(system: str, name: str, values: Sequence[Any]) -> str:
    """Write ``symbol = value unit`` for one or several values of a parameter.

    One without a symbol goes by its name.

    >>> quantity("belt", "frequency", [20.0, 50.0])
    'f = 20, 50 Hz'
    >>> quantity("belt", "corrections", [2])
    'corrections = 2'
    """
    row = field_info(SYSTEMS[system])[name]
    numbers = ", ".join(f"{value:.4g}" for value in sorted(set(values)))
    scale = "g" if row.scale == "g" else f" {row.scale}" if row.scale else ""
    return f"{row.symbol or name} = {numbers}{row.unit_text}{scale}"


def setting(system: str, name: str, value: object) -> str:
    """Write one value of a parameter, choices by name: ``θ = 16°``, ``integrator verlet``.

    Datasets have numbers for what is true or false:

    >>> setting("conveyor", "rotation", 0.0), setting("chute", "stress_profiles", True)
    ('no rotation', 'stress_profiles')
    """
    if isinstance(value, bool) or SYSTEMS[system].model_fields[name].annotation is bool:
        return name if value else f"no {name}"
    return f"{name} {value}" if isinstance(value, str) else quantity(system, name, [value])
