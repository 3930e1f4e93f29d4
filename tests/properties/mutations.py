"""Strategies: files of users with something wrong in them."""

import copy
from collections.abc import Sequence
from functools import reduce
from operator import getitem
from typing import Any

from hypothesis import strategies as st

from tests.properties.values import ANYTHING, GIVEN, SCALARS

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
