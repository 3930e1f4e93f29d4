"""Sums over samples: named tuples of arrays, of whichever kind, that can be added up."""

from collections.abc import Iterable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from sim.engine.compile import exact

#: What one sample, or several together, have added to each of several sums.
Sums = tuple[NamedTuple, ...]

_Kind = TypeVar("_Kind", bound=NamedTuple)


def plus(one: _Kind, other: _Kind) -> _Kind:
    """Return the sums of both."""
    return type(one)(*(mine + theirs for mine, theirs in zip(one, other, strict=True)))


def stacked(samples: int, one: _Kind) -> _Kind:
    """Return sums of zero of several samples, a first axis along which they lie."""
    parts: Iterable[Any] = one
    kind: Any = type(one)
    return kind(*(np.zeros((samples, *part.shape)) for part in parts))


def first_of(several: _Kind, samples: int) -> _Kind:
    """Return the sums of the first of several samples."""
    return type(several)(*(part[:samples] for part in several))


def copied(several: _Kind, number: int) -> _Kind:
    """Return the sums of one of several samples in arrays of their own."""
    return type(several)(*(part[number].copy() for part in several))


def chosen_of(several: _Kind, chosen: np.ndarray) -> _Kind:
    """Return the sums of several samples, zero where a sample is not among those chosen (K,)."""
    parts: Iterable[Any] = several
    kind: Any = type(several)
    return kind(*(part * chosen.reshape(-1, *[1] * (part.ndim - 1)) for part in parts))


def add_samples(total: NamedTuple, several: NamedTuple, first: int, last: int) -> None:
    """Add the sums of samples ``first``..``last`` of several, one after the other."""
    for mine, theirs in zip(total, several, strict=True):
        _add_rows(mine.reshape(-1), theirs.reshape(len(theirs), -1), first, last)


@exact
def _add_rows(total, rows, first, last):
    for row in range(first, last):
        for k in range(total.size):
            total[k] += rows[row, k]
