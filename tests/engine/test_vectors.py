"""What kernels ask of vector instructions: masked appending, and arrays that are apart."""

import numpy as np
import pytest

from tests.engine_motion.helpers import appended, gathered_sums

SPECIAL = np.array([np.nan, -np.nan, 0.0, -0.0, np.inf, -np.inf, 5e-324, -5e-324, 1.0, -1.0])


def appended_numbers(gap, size: int, first: int, free: int) -> np.ndarray:
    """What is appended to a list of which ``free`` entries are taken, which must stay."""
    out = np.arange(900, 900 + free + size + 8).astype(np.uint32)
    count = appended(gap, size, first, out, free)
    assert np.array_equal(out[:free], np.arange(900, 900 + free))
    return out[free : free + count]


@pytest.mark.parametrize("size", range(41))
def test_numbers_of_negative_gaps_are_appended_in_their_order(size):
    rng = np.random.default_rng(size)
    for share in (0.0, 0.1, 0.5, 0.9, 1.0):
        gap = rng.exponential(size=size + 3) * np.where(rng.random(size + 3) < share, -1.0, 1.0)
        for first, free in ((0, 0), (1000, 3), (2**32 - 64, 17)):
            expected = first + np.flatnonzero(gap[:size] < 0.0)
            assert np.array_equal(appended_numbers(gap, size, first, free), expected)


@pytest.mark.parametrize("size", range(1, 41))
def test_neither_zeros_nor_what_is_not_a_number_is_negative(size):
    rng = np.random.default_rng(size)
    for _ in range(20):
        gap = rng.choice(SPECIAL, size)
        assert np.array_equal(appended_numbers(gap, size, 5, 2), 5 + np.flatnonzero(gap < 0.0))


def test_no_more_than_eight_entries_behind_the_last_are_overwritten():
    rng = np.random.default_rng(1)
    for size in range(41):
        gap = rng.normal(size=size)
        out = np.full(64, 7, np.uint32)
        count = appended(gap, size, 100, out, 0)
        assert (out[count + 8 :] == 7).all()


def test_a_kernel_that_promises_arrays_apart_computes_the_same():
    rng = np.random.default_rng(2)
    source, index, out = rng.random(100), rng.integers(0, 100, 37), rng.random(37)
    expected = out + source[index]
    gathered_sums(source, index, out)
    assert np.array_equal(out, expected)
