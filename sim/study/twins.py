"""The points of a study by another engine, which a second opinion is asked for."""

from collections.abc import Mapping
from typing import Any

from sim.base.additions import plain_name, plugin_options
from sim.parameters import Parameters
from sim.parameters.engines import ENGINE
from sim.study.model import Study

#: The engine of this program; a second opinion compares it with another one.
OWN = ENGINE.usual[0]


def other_engines() -> Mapping[str, str]:
    """Return the engines besides that of this program as points name them, by plain name."""
    names = (*ENGINE.usual[1:], *plugin_options(ENGINE.name))
    return {plain_name(name): name for name in names}


def twin_of(parameters: Parameters, other: str) -> Parameters | None:
    """Return a point of one engine, ours or the other, by the second; None where it refuses it."""
    engine = getattr(parameters, ENGINE.name, "")
    if engine not in (OWN, other):
        return None
    option = parameters.option(ENGINE.name)
    values = {
        name: type(parameters).model_fields[name].default
        for name in ("threads", *option.owns, *option.parameters)
    }
    values[ENGINE.name] = other if engine == OWN else OWN
    twin: Any = parameters.model_copy(update=values)
    return None if twin.refusals else twin


def twins(study: Study, other: str) -> dict[str, Parameters]:
    """Return the points by the second of our engine and another, by the ids of those of a study."""
    every = {key: twin_of(point.parameters, other) for key, point in study.points.items()}
    return {key: twin for key, twin in every.items() if twin is not None}
