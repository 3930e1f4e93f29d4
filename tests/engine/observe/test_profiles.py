"""Profiles of known states: exact shares of particles, velocities, temperatures, also by phase."""

import numpy as np
import pytest

from sim.engine.observe.profiles import (
    AREA,
    CENTRE,
    VOLUME,
    Profile,
    add_sample,
    empty_profile,
    squares,
)
from sim.engine.observe.samples import add_samples, zero_samples
from sim.engine.systems.slices import BedProfiles

SLICE = 0.25e-3
TOTAL = {
    VOLUME: lambda radius: 4 / 3 * np.pi * radius**3,
    AREA: lambda radius: np.pi * radius**2,
    CENTRE: np.ones_like,
}


def profile_of(kind, height, radius, velocity, slices=60, slice_height=SLICE):
    profile = empty_profile(slices, np.shape(velocity)[1])
    arrays = [np.array(values, float) for values in (height, radius, np.transpose(velocity))]
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
