"""What holds for the law of the beads whatever its parameters, scales and contacts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.engine.contact.damping import spring_damping
from tests.engine_motion.helpers import disk_forces
from tests.properties.values import SEEDS, magnitudes, norms


@st.composite
def bead_contacts(draw, decades=3):
    """Y (N/m), γ and γ_s (1/s), and overlap, normal, velocity and masses of 50 contacts."""
    rng = np.random.default_rng(draw(SEEDS))
    angle = rng.uniform(0, 2 * np.pi, 50)
    rates = st.one_of(st.just(0.0), magnitudes(-decades, decades))
    law = {
        "stiffness": draw(magnitudes(-decades, decades)),
        "damping": draw(rates),
        "shear_damping": draw(rates),
    }
    return (
        law,
        draw(magnitudes(-decades, decades)) * rng.uniform(0, 1, 50),
        np.stack([np.cos(angle), np.sin(angle)], axis=1),
        draw(magnitudes(-decades, decades)) * rng.normal(size=(50, 2)),
        draw(magnitudes(-decades, decades)) * rng.uniform(0.1, 1, 50),
        draw(magnitudes(-decades, decades)) * rng.uniform(0.1, 1, 50),
    )


def parts(law: dict, damped, overlap, normal, velocity):
    """Spring, damping and drag (n, 2) of Eqs. 2-4 for the mass that is damped."""
    across = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    approach = (velocity * normal).sum(axis=1)
    sliding = (velocity * across).sum(axis=1)
    return (
        -law["stiffness"] * overlap[:, None] * normal,
        -(law["damping"] * damped * approach)[:, None] * normal,
        -(law["shear_damping"] * damped * sliding)[:, None] * across,
    )


MASSES = st.sampled_from(["own", "reduced"])


@given(bead_contacts(decades=12), MASSES)
def test_forces_of_beads_are_as_printed_at_all_magnitudes(contacts, damping_mass):
    law, overlap, normal, velocity, mass, other = contacts
    damped = mass if damping_mass == "own" else mass * other / (mass + other)
    expected = parts(law, damped, overlap, normal, velocity)
    rounding = 1e-12 * sum(map(norms, expected))
    for attraction in ("kept", "clipped"):
        compiled = spring_damping(**law, damping_mass=damping_mass, attraction=attraction)
        found = disk_forces(compiled, overlap, normal, velocity, mass, 1 / other)
        assert np.isfinite(found).all()
        pull = ((expected[0] + expected[1]) * normal).sum(axis=1) > 0
        cut = pull[:, None] & (attraction == "clipped")
        wanted = np.where(cut, 0.0, expected[0] + expected[1]) + expected[2]
        assert (norms(found - wanted) <= rounding).all()


@given(
    magnitudes(-3, 6), st.floats(0, 1.99), magnitudes(-9, 3), magnitudes(-9, 3), magnitudes(-3, 3)
)
def test_an_impact_of_beads_has_the_restitution_of_a_damped_spring(
    stiffness, damping_ratio, mass, other, speed
):
    """With the reduced mass, an overlap v/w exp(-c t) sin(w t) is the motion of the pair."""
    reduced = mass * other / (mass + other)
    natural = np.sqrt(stiffness / reduced)
    decay = damping_ratio / 2 * natural
    rate = np.sqrt(natural**2 - decay**2)
    law = spring_damping(stiffness, 2 * decay, 0.0, damping_mass="reduced")
    time = np.linspace(0, np.pi / rate, 101)[:, None]
    growth = speed * np.exp(-decay * time)
    overlap = growth / rate * np.sin(rate * time)
    approach = growth * (np.cos(rate * time) - decay / rate * np.sin(rate * time))
    acceleration = -2 * decay * approach - natural**2 * overlap
    normal = np.tile([1.0, 0.0], (101, 1))
    force = disk_forces(
        law, overlap[:, 0], normal, approach * normal, np.full(101, mass), np.full(101, 1 / other)
    )
    assert np.abs(force[:, 0] - reduced * acceleration[:, 0]).max() <= (
        1e-9 * reduced * natural * speed
    )
    assert -approach[-1, 0] == pytest.approx(speed * np.exp(-np.pi * decay / rate), rel=1e-9)
