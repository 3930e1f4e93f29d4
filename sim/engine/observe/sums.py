"""Sums over samples: named tuples of arrays, of any type, that can be added."""

from collections.abc import Iterable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from sim.engine.compile import exact

#: Several sums of different types, over one sample or more.
Sums = tuple[NamedTuple, ...]

_Kind = TypeVar("_Kind", bound=NamedTuple)


def add_sums(first: _Kind, second: _Kind) -> _Kind:
    """Return the sum of two sums, array by array."""
    return type(first)(*(a + b for a, b in zip(first, second, strict=True)))


def zero_samples(samples: int, template: _Kind) -> _Kind:
    """Return sums of zero like ``template``, with a first axis over the samples."""
    parts: Iterable[Any] = template
    kind: Any = type(template)
    return kind(*(np.zeros((samples, *part.shape)) for part in parts))


def first_samples(sums: _Kind, samples: int) -> _Kind:
    """Return the sums of the first ``samples`` samples."""
    return type(sums)(*(part[:samples] for part in sums))


def copy_sample(sums: _Kind, number: int) -> _Kind:
    """Return a copy of the sums of sample ``number``."""
    return type(sums)(*(part[number].copy() for part in sums))


def mask_samples(sums: _Kind, mask: np.ndarray) -> _Kind:
    """Return the sums by sample, set to zero where ``mask`` (K,) is false."""
    parts: Iterable[Any] = sums
    kind: Any = type(sums)
    return kind(*(part * mask.reshape(-1, *[1] * (part.ndim - 1)) for part in parts))


def add_samples(total: NamedTuple, sums: NamedTuple, first: int, last: int) -> None:
    """Add the sums of samples ``first`` to ``last`` - 1 to a total, one after the other."""
    for target, source in zip(total, sums, strict=True):
        _add_rows(target.reshape(-1), source.reshape(len(source), -1), first, last)


@exact
def _add_rows(total, rows, first, last):
    for row in range(first, last):
        for k in range(total.size):
            total[k] += rows[row, k]
