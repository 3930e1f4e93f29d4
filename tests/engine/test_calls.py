"""Kernels called without a look at their arguments, and at their addresses."""

from typing import NamedTuple

import numpy as np

from sim.engine.calls import DirectCall, address_of, call, kind_of
from sim.engine.compile import exact, kernel


class Pair(NamedTuple):
    """Numbers and what they are multiplied with."""

    values: np.ndarray
    factor: float


@kernel
def _sum_of(pair, first):
    total = 0.0
    for k in range(first, pair.values.size):
        total += pair.factor * pair.values[k]
    return total


@kernel
def _scale(pair):
    for k in range(pair.values.size):
        pair.values[k] *= pair.factor


@exact
def _scaled_sum(sum_of, scale, pair, first):
    call(scale, None, pair)
    return call(sum_of, 0.0, pair, first)


def test_a_direct_call_does_what_the_kernel_does():
    pair = Pair(np.random.default_rng(1).random(1000), 0.3)
    direct = DirectCall(_sum_of, kind_of(pair))
    assert direct(pair, 3) == direct(pair, 3) == _sum_of(pair, 3)
    other = Pair(np.ones(5), 2.0)
    assert DirectCall(_sum_of, kind_of(other))(other, 1) == 8.0


def test_a_call_at_an_address_is_the_same_machine_code():
    """To the bit, though the sum may be taken in any order where it is compiled once more."""
    for size in range(1, 200, 7):
        pair = Pair(np.random.default_rng(size).random(size), 0.3)
        sum_of = address_of(_sum_of, "test", pair, 0)
        scale = address_of(_scale, "test", pair)
        again = Pair(pair.values.copy(), 0.3)
        _scale(again)
        assert _scaled_sum(sum_of, scale, pair, 0) == _sum_of(again, 0)
        assert np.array_equal(pair.values, again.values)
