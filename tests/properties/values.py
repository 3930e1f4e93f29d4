"""Strategies: points over the whole ranges of their parameters, values of every kind and size."""

import datetime
import typing

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from hypothesis import strategies as st
from pydantic.fields import FieldInfo

from sim.parameters import SYSTEMS
from sim.parameters.common import LARGEST, SMALLEST

SEEDS = st.integers(0, 2**32 - 1)

#: Most integers that a point may count have no upper bound of their own.
_LARGEST_COUNT = 10**7

AWKWARD = st.sampled_from(
    [
        None,
        True,
        float("nan"),
        float("-inf"),
        -0.0,
        1e308,
        5e-324,
        10**400,
        "",
        "{x}",
        "%s",
        "a\nb",
        "\0",
        "\x1b[31m",
        "\u2028\u202e",
        "\ud800",
        "chute",
        b"\xff\0",
        datetime.date(1, 1, 1),
        datetime.datetime(9999, 12, 31),
        object,
        1j,
    ]
)
SCALARS = st.one_of(
    AWKWARD, st.integers(), st.floats(), st.text(max_size=20), st.binary(max_size=9)
)


def _collections(values: st.SearchStrategy) -> st.SearchStrategy:
    return st.one_of(
        st.lists(values, max_size=4),
        st.lists(values, max_size=3).map(tuple),
        st.dictionaries(SCALARS, values, max_size=4),
        st.frozensets(SCALARS, max_size=3),
    )


#: Whatever Python can hold, nested.
ANYTHING = st.recursive(SCALARS, _collections, max_leaves=8)


def allowed(field: FieldInfo) -> st.SearchStrategy:
    """Values in the range of a parameter, its ends and all magnitudes included."""
    if typing.get_origin(field.annotation) is typing.Literal:
        return st.sampled_from(typing.get_args(field.annotation))
    if field.annotation is bool:
        return st.booleans()
    if field.annotation is str:
        return st.sampled_from(["", "run.nc", "../ä b.nc", "belt-frequency20-00000000"])
    low, high, open_end = 0, None, False
    for bound in field.metadata:
        match bound:
            case Gt(gt=value):
                low = max(value, SMALLEST)
            case Ge(ge=value):
                low = value
            case Le(le=value):
                high = value
            case Lt(lt=value):
                high, open_end = value, True
    if field.annotation is int:
        return st.integers(low, high or _LARGEST_COUNT)
    # A value rounded to 12 digits must not reach an open end.
    high = (high or LARGEST) * (1 - 1e-11 if open_end else 1)
    powers = st.floats(-15, 15).map(lambda power: 10**power)
    return st.one_of(st.floats(low, high), powers.filter(lambda x: low <= x <= high))


def _changed(system: str) -> st.SearchStrategy[dict]:
    fields = SYSTEMS[system].model_fields
    names = st.lists(st.sampled_from(sorted(set(fields) - {"system"})), max_size=5, unique=True)
    return names.flatmap(
        lambda chosen: st.fixed_dictionaries(
            {"system": st.just(system)} | {name: allowed(fields[name]) for name in chosen}
        )
    )


#: Parameters given for a point, each within its own range; rules that join several may refuse them.
GIVEN = st.one_of([_changed(system) for system in SYSTEMS])


def magnitudes(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers of all magnitudes from 10**low to 10**high."""
    return st.floats(low, high).map(lambda power: 10.0**power)


def norms(vectors) -> np.ndarray:
    """Lengths (n,) of vectors (n, D)."""
    return np.linalg.norm(vectors, axis=1)
