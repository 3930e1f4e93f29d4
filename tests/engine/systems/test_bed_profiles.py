"""Profiles of the bed that tell phases of the cycle apart, on beads whose motion is known."""

import numpy as np
import pytest

from sim.engine.observe.field import squares
from sim.engine.observe.profiles import CENTRE, Profile, add_sample, empty_profile
from sim.engine.observe.samples import add_samples, zero_samples
from sim.engine.systems.slices import BedProfiles, bed_profiles
from tests.engine_motion.points import belt_point

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


@pytest.mark.parametrize("cycles", [1, 3, 50])
def test_few_cycles_are_not_colder(cycles):
    """A mean over few beads takes some of their scatter with it; that is allowed for."""
    slices, sums = shaken(cycles, 0.1, 0.0)
    assert slices.tables(sums)[NAME].mean() == pytest.approx(0.01, rel=0.15)


def test_a_slice_without_a_second_bead_at_any_phase_has_no_temperature():
    slices, sums = shaken(1, 0.1, 0.0)
    centres, *_, phases = sums
    phases.count[:, 3] = centres.weight[3] / PHASES
    centres.weight[3] = PHASES
    assert np.isnan(slices.tables(sums)[NAME][3])


def test_phases_are_told_apart_where_they_are_asked_for():
    assert bed_profiles(belt_point(fluctuation_profiles=True)).phases == 20
    usual = bed_profiles(belt_point())
    assert usual.phases == 0 and len(usual.empty()) == 3
    both = bed_profiles(belt_point(fluctuation_profiles=True, phase_0_profiles=True))
    assert len(both.empty()) == 6
