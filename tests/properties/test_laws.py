"""What holds for the laws of beads and spheres whatever their parameters, scales and contacts."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.claims.experiments import contact_path
from sim.engine.contact.damping import spring_damping
from sim.engine.contact.walton_braun import walton_braun
from tests.engine_motion.helpers import (
    CONTACT_LAWS,
    READINGS,
    disk_forces,
)
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


STEPS = 200
Z = np.array([0.0, 0.0, 1.0])

#: Readings of the law of the spheres: those that other tests compile too, in a search all.
SEARCHED = st.sampled_from(CONTACT_LAWS if settings.default.max_examples <= 50 else READINGS)


@st.composite
def sphere_laws(draw, decades=3, readings=SEARCHED):
    """Laws of the spheres with a stiffness around 1 N/m, and any friction and restitution.

    Below a restitution of 1e-5 the rounding of 1 - e**2 reaches the force.
    """
    return walton_braun(
        stiffness=draw(magnitudes(-decades, decades)),
        restitution=draw(st.one_of(st.just(1.0), st.floats(1e-3, 1))),
        friction=draw(st.one_of(st.just(0.0), st.floats(0.1, 2), magnitudes(-decades, 1))),
        tangential_ratio=draw(magnitudes(-decades / 3, decades / 3)),
        **draw(readings),
    )


def history(law, seed: int, length: float, slip: float, steps: int = STEPS):
    """Overlaps (n,) around ``length`` (m), normals and slips (n, 3) of a contact that wanders.

    ``slip`` is the size of a step's slip over the one that takes the friction to its limit.
    """
    rng = np.random.default_rng(seed)
    overlap = length * (1.05 + np.sin(rng.normal(0, 0.2, steps).cumsum()))
    normal = Z + 0.03 * rng.normal(size=(steps, 3)).cumsum(axis=0)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    size = slip * length * max(law.limit.friction, 1e-9) * law.loading / law.tangential
    steps_of_slip = size * np.sin(rng.normal(0, 0.3, (steps, 3)).cumsum(axis=0))
    steps_of_slip -= (steps_of_slip * normal).sum(axis=1)[:, None] * normal
    return overlap, normal, steps_of_slip


@given(sphere_laws(decades=12), SEEDS, magnitudes(-12, 12), magnitudes(-6, 3))
def test_spheres_repel_and_rub_within_the_limit_at_all_magnitudes(law, seed, length, slip):
    overlap, normal, slips = history(law, seed, length, slip)
    force, friction, memory = contact_path(law, overlap, normal, slips)
    assert np.isfinite(memory).all() and np.isfinite(friction).all()
    assert (force >= 0.0).all()
    assert (force <= law.loading * overlap * (1 + 1e-12)).all()
    limit = law.limit.friction * force
    assert (norms(friction) <= limit * (1 + 1e-12)).all()
    assert (np.abs((friction * normal).sum(axis=1)) <= 1e-9 * limit.max()).all()


def same_friction(found, expected, limit) -> bool:
    """Whether two frictions (n, 3) agree but for rounding, which the exponents may magnify."""
    return bool((norms(found - expected) <= 1e-7 * limit.max()).all())


@given(sphere_laws(), SEEDS, magnitudes(-3, 1), magnitudes(-6, 6), magnitudes(-6, 6))
def test_forces_scale_with_stiffness_and_length(law, seed, slip, stiffer, longer):
    overlap, normal, slips = history(law, seed, 1e-5, slip)
    force, friction, _ = contact_path(law, overlap, normal, slips)
    stiff = law._replace(
        loading=stiffer * law.loading,
        unloading=stiffer * law.unloading,
        tangential=stiffer * law.tangential,
    )
    scale = stiffer * longer
    found = contact_path(stiff, longer * overlap, normal, longer * slips)
    # Where the force ends in unloading it is a difference of nearly equal numbers.
    assert (np.abs(found[0] - scale * force) <= 1e-12 * scale * law.unloading * overlap).all()
    limit = law.limit.friction * law.unloading * overlap
    assert same_friction(found[1] / scale, friction, limit)
