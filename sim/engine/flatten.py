"""Nested structures as flat dictionaries of arrays and numbers by place, and back.

A state is kept as data alone: what kind of thing holds them, a structure made anew says. Whatever
lies in a file can therefore become numbers of a flow and nothing else.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

#: Arrays and numbers by place, as ``spheres.position``.
FlatState = dict[str, Any]

_NUMBERS = (bool, int, float, str, np.generic)


def flattened(structure: Any) -> FlatState:
    """Return all arrays and numbers of nested tuples, lists and dictionaries."""
    return dict(_flattened(structure, ""))


def _flattened(value: Any, place: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, np.generic):
        yield place, value.item()
    elif isinstance(value, (np.ndarray, *_NUMBERS)):
        yield place, value
    else:
        for name, part in _parts(value).items():
            yield from _flattened(part, _within(place, name))


def _parts(value: Any) -> Mapping[Any, Any]:
    if isinstance(value, dict):
        return value
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return value._asdict()
    if isinstance(value, (tuple, list)):
        return dict(enumerate(value))
    raise TypeError(f"{type(value).__name__} is not kept in states")


def _within(place: str, name: Any) -> str:
    return f"{place}.{name}" if place else str(name)


def part_at(place: str, held: Mapping[str, Any]) -> FlatState:
    """Return the values whose places begin with ``place``, named by the rest of their places."""
    prefix = f"{place}."
    return {name[len(prefix) :]: held[name] for name in held if name.startswith(prefix)}


def refilled(structure: Any, held: Mapping[str, Any], growing: int = -1) -> Any:
    """Return a structure of the same kind that holds other arrays and numbers.

    What is one array in two places of the structure is one in what is returned. Arrays may be
    longer or shorter along the ``growing`` axis, as those of contacts are where there are more.

    Raises
    ------
    ValueError
        When ``held`` has other places than the structure, or arrays of another type or of
        other lengths there.
    """
    expected = flattened(structure)
    if expected.keys() != held.keys():
        odd = min(expected.keys() ^ held.keys())
        raise ValueError(f"{odd} is not in both")
    for place, value in expected.items():
        if _kind(value) != _kind(held[place]):
            raise ValueError(f"{place} is of another kind")
        one, other = np.shape(value), np.shape(held[place])
        if _without(one, growing) != _without(other, growing):
            raise ValueError(f"{place} has the lengths {other}, not {one}")
    return _filled(structure, held, "", {})


def _kind(value: Any) -> tuple[Any, ...]:
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim
    return (str if isinstance(value, str) else float,)


def _without(lengths: tuple[int, ...], axis: int) -> tuple[int, ...]:
    return lengths[:axis] + lengths[axis:][1:]


def _filled(value: Any, held: Mapping[str, Any], place: str, known: dict[int, Any]) -> Any:
    if isinstance(value, np.ndarray):
        return known.setdefault(id(value), held[place])
    if isinstance(value, _NUMBERS):
        return held[place]
    parts = {
        name: _filled(part, held, _within(place, name), known)
        for name, part in _parts(value).items()
    }
    if isinstance(value, dict):
        return parts
    if hasattr(value, "_asdict"):
        return type(value)(**parts)
    return type(value)(parts.values())
