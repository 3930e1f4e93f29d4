"""Sums over samples: named tuples of arrays, of whichever kind, that can be added up."""

from typing import NamedTuple, TypeVar

import numpy as np

#: What one sample, or several together, have added to each of several sums.
Sums = tuple[NamedTuple, ...]

_Kind = TypeVar("_Kind", bound=NamedTuple)


def plus(one: _Kind, other: _Kind) -> _Kind:
    """Return the sums of both."""
    return type(one)(*(mine + theirs for mine, theirs in zip(one, other, strict=True)))


def zeros(one: _Kind) -> _Kind:
    """Return sums of the same shapes without any sample."""
    return type(one)(*map(np.zeros_like, one))
