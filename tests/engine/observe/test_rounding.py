"""Compiled sums and products have the bits of numpy's, whatever their length."""

import numpy as np
import pytest

from sim.engine.observe.totals import COMPLEX, REAL, product, square, total

SIZES = [1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 63, 64, 65, 127, 128, 129, 136, 200, 255, 256, 257, 1000]


@pytest.mark.parametrize("size", [*SIZES, 4096, 10_007])
def test_sums_are_those_of_numpy(size):
    rng = np.random.default_rng(size)
    for scale in (1.0, 1e8):
        real, imaginary = rng.normal(scale, 1.0, (2, size)) * 10.0 ** rng.integers(-9, 9, (2, size))
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
