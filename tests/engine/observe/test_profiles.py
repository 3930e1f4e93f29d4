"""Profiles of known states: exact shares of particles, velocities, temperatures, also by phase."""

import numpy as np
import pytest

from sim.engine.observe.profiles import (
    AREA,
    CENTRE,
    COMPLEX,
    REAL,
    VOLUME,
    Profile,
    add_sample,
    empty_profile,
    product,
    square,
    squares,
    total,
)
from sim.engine.observe.samples import MAX_BLOCKS, ProfileBlocks, add_samples, zero_samples
from sim.engine.systems.slices import BedProfiles

SLICE = 0.25e-3
TOTAL = {
    VOLUME: lambda radius: 4 / 3 * np.pi * radius**3,
    AREA: lambda radius: np.pi * radius**2,
    CENTRE: np.ones_like,
}


def profile_of(kind, height, radius, velocity, slices=60, slice_height=SLICE):
    profile = empty_profile(slices, np.shape(velocity)[1])
    arrays = [np.array(one, float, order="C") for one in (height, radius, np.transpose(velocity))]
    add_sample(profile, kind, slice_height, *arrays)
    return profile


def random_state(number=200, dimension=3):
    rng = np.random.default_rng(1)
    radius = 0.5e-3 * rng.uniform(0.5, 1.5, number)
    return rng.uniform(1e-3, 10e-3, number), radius, rng.normal(0, 0.1, (number, dimension))


@pytest.mark.parametrize("kind", TOTAL)
def test_slices_hold_each_particle_exactly_once(kind):
    height, radius, velocity = random_state()
    profile = profile_of(kind, height, radius, velocity)
    assert profile.weight.sum() == pytest.approx(TOTAL[kind](radius).sum(), rel=1e-12)
    for z, r in zip(height[:20], radius[:20], strict=True):
        one = profile_of(kind, [z], [r], velocity[:1])
        assert one.weight.sum() == pytest.approx(float(TOTAL[kind](np.array(r))), rel=1e-11)
        filled = np.flatnonzero(one.weight > 1e-12 * one.weight.sum())
        assert filled[0] * SLICE > z - r - SLICE and (filled[-1] + 1) * SLICE < z + r + SLICE


@pytest.mark.parametrize("kind", [VOLUME, AREA])
def test_share_of_a_slice_is_the_integral_of_the_cross_section(kind):
    """Chords (area) or discs (volume) summed over thin layers."""
    height, radius = 3.07e-3, 0.62e-3
    level = (np.arange(600_000) + 0.5) * 10e-3 / 600_000
    inside = np.clip(radius**2 - (level - height) ** 2, 0, None)
    section = np.pi * inside if kind == VOLUME else 2 * np.sqrt(inside)
    expected = (section * 10e-3 / 600_000).reshape(40, -1).sum(axis=1)
    found = profile_of(kind, [height], [radius], [[0, 0, 0]], slices=40).weight
    assert found == pytest.approx(expected, abs=1e-7 * expected.sum())


def test_temperature_of_a_known_state_per_direction():
    rng = np.random.default_rng(3)
    spread = np.array([0.3, 0.2, 0.1])
    velocity = rng.normal([5.0, 0, 0], spread, (100_000, 3))
    height = rng.uniform(1e-3, 4e-3, 100_000)
    profile = profile_of(VOLUME, height, np.full(100_000, 0.5e-3), velocity, slices=16)
    assert profile.temperature()[6:14] == pytest.approx(np.tile(spread**2, (8, 1)), rel=0.02)
    assert profile.velocity()[6:14] == pytest.approx(5.0, rel=0.01)


PHASES, SLICES, BEADS = 8, 10, 40
NAME = "fluctuation_temperature_profile"


def shaken(cycles: int, noise: float, stretch: float) -> tuple[BedProfiles, list]:
    """A bed that is stretched by the cycle, and whose beads differ from that by noise (m/s)."""
    slices = BedProfiles(SLICES, 1.0, 1.0, squares(1.0, 1.0, 0.0), False, PHASES)
    rng, phase = np.random.default_rng(1), np.arange(cycles * PHASES) % PHASES
    centres = zero_samples(len(phase), empty_profile(SLICES, 2))
    for k, number in enumerate(phase):
        height = rng.uniform(0.0, SLICES, BEADS)
        velocity = rng.normal(0.0, noise, (2, BEADS))
        velocity[1] += stretch * np.floor(height) * np.sin(2 * np.pi * number / PHASES)
        one = Profile(*(part[k] for part in centres))
        add_sample(one, CENTRE, 1.0, height, np.full(BEADS, 0.1), velocity)
    total, area, field, phases = slices.empty()
    (by_phase,) = slices.phase_sums(centres, centres, phase)
    for mine, theirs in ((total, centres), (phases, by_phase)):
        add_samples(mine, theirs, 0, len(phase))
    return slices, [total, area, field, phases]


def test_what_the_bed_does_in_every_cycle_is_no_fluctuation():
    """Stretching counts in the granular temperature, and not in that about the phase average."""
    noise, tops = 0.1, [0, -1]
    slices, sums = shaken(200, noise, stretch=0.3)
    usual = sums[0].temperature().mean(axis=1)
    # What is left of the stretching is that of the mean of all beads, which are few.
    assert usual[tops].min() > 20 * slices.tables(sums)[NAME][tops].max()
    slices, sums = shaken(200, noise, stretch=0.0)
    found = slices.tables(sums)[NAME]
    assert found == pytest.approx((1 - 1 / BEADS) * noise**2, rel=0.06)


@pytest.mark.parametrize("cycles", [1, 50])
def test_few_cycles_are_not_colder(cycles):
    """A mean over few beads takes some of their scatter with it; that is allowed for."""
    slices, sums = shaken(cycles, 0.1, 0.0)
    assert slices.tables(sums)[NAME].mean() == pytest.approx(0.01, rel=0.15)


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
