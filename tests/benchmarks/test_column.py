"""The column of beads that explains the onset on the belt, in its limits."""

from math import pi, sqrt

import pytest

from benchmarks.column import GRAVITY, Column, transport


@pytest.mark.parametrize("amplitude", [0.5, 1.0, 1.5])
def test_transport_begins_where_the_belt_reaches_the_acceleration_of_gravity(amplitude):
    onset = sqrt(GRAVITY / amplitude) / (2 * pi)
    assert abs(transport(0.93 * onset, amplitude)) < 1e-3
    assert 0.1 < transport(1.12 * onset, amplitude) < 1


def test_a_single_bead_at_rest_on_the_belt_is_not_transported():
    assert abs(transport(12, column=Column(beads=1))) < 1e-6


def test_without_shear_friction_nothing_is_transported():
    assert transport(40, column=Column(shear_damping=0.0)) == 0


def test_flat_vibrations_carry_the_same_share_of_the_belts_velocity():
    """The vertical motion does not know of the horizontal one, which is linear in it."""
    assert transport(20, angle=30) == pytest.approx(transport(20, angle=60))
