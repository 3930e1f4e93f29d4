"""Conversion of nested structures to flat dictionaries of arrays and numbers by path, and back.

A state is stored as data alone; a new structure supplies the types of the containers. So the
content of a file can become numbers of a flow and nothing else.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

#: Arrays and numbers by path in the structure, such as ``spheres.position``.
FlatState = dict[str, Any]

_NUMBERS = (bool, int, float, str, np.generic)


def flatten(structure: Any) -> FlatState:
    """Return all arrays and numbers of nested tuples, lists and dictionaries, by path."""
    return dict(_flatten_parts(structure, ""))


def _flatten_parts(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, np.generic):
        yield path, value.item()
    elif isinstance(value, (np.ndarray, *_NUMBERS)):
        yield path, value
    else:
        for name, part in _parts(value).items():
            yield from _flatten_parts(part, _join(path, name))


def _parts(value: Any) -> Mapping[Any, Any]:
    if isinstance(value, dict):
        return value
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return value._asdict()
    if isinstance(value, (tuple, list)):
        return dict(enumerate(value))
    raise TypeError(f"{type(value).__name__} is not kept in states")


def _join(path: str, name: Any) -> str:
    return f"{path}.{name}" if path else str(name)


def subtree(path: str, values: Mapping[str, Any]) -> FlatState:
    """Return the values whose paths begin with ``path``, named by the rest of their paths."""
    prefix = f"{path}."
    return {name[len(prefix) :]: values[name] for name in values if name.startswith(prefix)}


def refill(structure: Any, values: Mapping[str, Any], growing_axis: int = -1) -> Any:
    """Return a structure of the same kind that holds other arrays and numbers.

    An array that occurs at two paths of the structure is one array in the result, too. Arrays may
    be longer or shorter along ``growing_axis``, as those of contacts are when their number changes.

    Raises
    ------
    ValueError
        When ``values`` has other paths than the structure, or an array there has another type or
        other lengths.
    """
    expected = flatten(structure)
    if expected.keys() != values.keys():
        odd = min(expected.keys() ^ values.keys())
        raise ValueError(f"{odd} is not in both")
    for path, value in expected.items():
        if _kind(value) != _kind(values[path]):
            raise ValueError(f"{path} is of another kind")
        old, new = np.shape(value), np.shape(values[path])
        if _drop_axis(old, growing_axis) != _drop_axis(new, growing_axis):
            raise ValueError(f"{path} has the lengths {new}, not {old}")
    return _fill(structure, values, "", {})


def _kind(value: Any) -> tuple[Any, ...]:
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim
    return (str if isinstance(value, str) else float,)


def _drop_axis(lengths: tuple[int, ...], axis: int) -> tuple[int, ...]:
    return lengths[:axis] + lengths[axis:][1:]


def _fill(value: Any, values: Mapping[str, Any], path: str, arrays: dict[int, Any]) -> Any:
    """Return the counterpart of a value; ``arrays`` maps ids of arrays already met to new ones."""
    if isinstance(value, np.ndarray):
        return arrays.setdefault(id(value), values[path])
    if isinstance(value, _NUMBERS):
        return values[path]
    parts = {
        name: _fill(part, values, _join(path, name), arrays) for name, part in _parts(value).items()
    }
    if isinstance(value, dict):
        return parts
    if hasattr(value, "_asdict"):
        return type(value)(**parts)
    return type(value)(parts.values())
