"""Sums over samples, over blocks of them, and with the bits of numpy's."""

import numpy as np
import pytest

from sim.engine.observe.profiles import COMPLEX, REAL, empty_profile, product, square, total
from sim.engine.observe.samples import MAX_BLOCKS, ProfileBlocks, zero_samples


def make_blocks(samples: int, at_once: int = 7) -> ProfileBlocks:
    """Blocks of a profile whose sample k has the weight k, added some at once."""
    blocks = ProfileBlocks()
    for first in range(0, samples, at_once):
        number = np.arange(first, min(first + at_once, samples))
        sums = zero_samples(len(number), empty_profile(1, 2))
        sums.samples[:, 0], sums.weight[:, 0] = 1.0, number
        blocks.add((sums,))
    return blocks


@pytest.mark.parametrize("at_once", [1, 5, 64])
def test_it_does_not_matter_how_many_come_at_once(at_once):
    rng, blocks = np.random.default_rng(1), [ProfileBlocks(), ProfileBlocks()]
    sums = zero_samples(300, empty_profile(2, 2))
    sums.weight[:] = rng.normal(size=sums.weight.shape)
    for sizes, mine in zip((at_once, 300), blocks, strict=True):
        for first in range(0, 300, sizes):
            part = type(sums)(*(values[first : first + sizes] for values in sums))
            mine.add((part,))
    (one,), (other,) = (mine.sum_since(100) for mine in blocks)
    assert np.array_equal(one.weight, other.weight)
    assert np.array_equal(blocks[0].latest[0].weight, sums.weight[-1])


@pytest.mark.parametrize("samples", [1, 5, MAX_BLOCKS, MAX_BLOCKS + 1, 10 * MAX_BLOCKS + 3])
def test_all_blocks_together_hold_all_samples(samples):
    made = make_blocks(samples)
    (total,) = made.sum_since(0)
    assert total.samples[0] == samples
    assert total.weight[0] == sum(range(samples))
    assert ProfileBlocks().sum_since(0) is None and ProfileBlocks().latest is None
    assert made.latest[0].weight[0] == samples - 1
    assert made.sum_since(10**9)[0].samples[0] > 0
    first = 0
    assert len(made.blocks()) < MAX_BLOCKS
    for end, (sums,) in made.blocks():
        assert sums.samples[0] == end - first
        assert sums.weight[0] == sum(range(first, end))
        first = end
    assert first == samples


@pytest.mark.parametrize("start", [1, 7, 100, 333])
def test_a_late_start_leaves_out_what_comes_before_it(start):
    samples = 400
    (total,) = make_blocks(samples).sum_since(start)
    counted = int(total.samples[0])
    assert samples - start - samples // (MAX_BLOCKS // 2) <= counted <= samples - start
    assert total.weight[0] == sum(range(samples - counted, samples))


SIZES = [1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 63, 64, 65, 127, 128, 129, 136, 200, 255, 256, 257, 1000]


def test_sums_are_those_of_numpy():
    for size in [*SIZES, 4096, 10_007]:
        rng = np.random.default_rng(size)
        real, imaginary = rng.normal(1e4, 1e4, (2, size)) * 10.0 ** rng.integers(-9, 9, (2, size))
        whole = (real + 1j * imaginary).sum()
        assert total(real, REAL) == real.sum()
        assert total(real, COMPLEX) == whole.real and total(imaginary, COMPLEX) == whole.imag


def test_products_are_those_of_the_powers_of_an_array():
    wave = np.exp(1j * np.random.default_rng(1).uniform(-9, 9, 1000))
    for one, second, third, fourth in zip(wave, wave**2, wave**3, wave**4, strict=True):
        pair = one.real, one.imag
        assert complex(*square(pair)) == second
        twice = product(pair, pair)
        assert complex(*product(pair, twice)) == third
        assert complex(*product(twice, twice)) == fourth
