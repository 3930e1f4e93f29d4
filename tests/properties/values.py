"""Strategies: points over the whole ranges of their parameters, values of every kind and size."""

import copy
import datetime
import typing
from collections.abc import Sequence
from functools import reduce
from operator import getitem
from typing import Any

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from hypothesis import strategies as st
from pydantic import WithJsonSchema
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
    if any(isinstance(one, WithJsonSchema) for one in field.metadata):
        return st.sampled_from(
            ["", "angle 0:10 0.5:20", {"angle": [[0, 30], [1e-6, 30], [1e-6, 0]]}]
        )
    if field.annotation is str and "csv" in str(field.metadata):
        return st.sampled_from(["", "x (d), z (d)\n1, 3\n"])
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


#: What YAML gives a meaning, and what it gave one in older versions.
TOKENS = st.sampled_from(
    [
        *":?-,[]{}#&*!|>'\"%@`~\t\n\r\x85\u2028\ufeff\0",
        *("---", "...", "<<: *a", "<<: [*a, *a]", "? [a]", "&a", "*a", "*depths", "null", "true"),
        *("0x1f", "1e999", ".nan", "-.inf", "010", "1:30", "2001-01-01", "%YAML 1.1", "\\0"),
        *("!!set", "!!binary", "!!timestamp", "!!omap", "!!python/object:os.system", "!!int"),
        *("!!float", "!!bool", "!!str", "!!null", "!!merge", "!!seq", "!!map", "!!value"),
    ]
)


@st.composite
def mutated_texts(draw, texts: Sequence[str]) -> str:
    """One of some texts with characters flipped, taken out, doubled or put in."""
    text = draw(st.sampled_from(texts))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = start + draw(st.integers(0, 30))
        new = draw(st.one_of(TOKENS, st.text(max_size=3), st.just(2 * text[start:end])))
        text = text[:start] + new + text[end:]
    return text


def places(tree: Any, path: tuple = ()) -> list[tuple]:
    """Paths of all nodes of a tree."""
    members = {dict: dict.items, list: enumerate}.get(type(tree), lambda _: ())(tree)
    return [path, *(found for key, value in members for found in places(value, (*path, key)))]


@st.composite
def mutated_trees(
    draw, trees: Sequence[dict], values: st.SearchStrategy = ANYTHING, keys: Any = SCALARS
) -> dict:
    """One of some trees with nodes taken out, doubled, exchanged or replaced by ``values``."""
    tree = copy.deepcopy(draw(st.sampled_from(trees)))
    for _ in range(draw(st.integers(1, 3))):
        *path, key = draw(st.sampled_from(places(tree)[1:] or [(draw(keys),)]))
        parent = reduce(getitem, path, tree)
        match draw(st.sampled_from(["delete", "double", "replace", "exchange", "rename", "point"])):
            case "delete" if len(tree) > 1:
                del parent[key]
            case "double" if isinstance(parent, list):
                parent.insert(key, parent[key])
            case "exchange":
                other = draw(st.sampled_from(places(tree)))
                parent[key] = copy.deepcopy(reduce(getitem, other, tree))
            case "rename" if isinstance(parent, dict) and key in parent:
                parent[draw(keys)] = parent.pop(key)
            case "point":
                parent[key] = draw(GIVEN)
            case _:
                parent[key] = draw(values)
    return tree
