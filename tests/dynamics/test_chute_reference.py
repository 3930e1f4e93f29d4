"""The loop over steps of the spheres against the slow reference, from dense random states."""

import numpy as np
import pytest

from sim.dynamics import leap_frog
from tests.engine_helpers import (
    GRAVITY,
    MASS,
    RADIUS,
    lattice,
    sphere_law,
    weight_components,
    wrapped,
)
from tests.motions import SphereMotion
from tests.reference import chute as slow
from tests.reference.walton_braun import ContactLaw

STEPS = 80
SPEED, SPIN = 0.05, 100.0

#: Every exponent, overlap memory and cap occurs; the contact's own tests take all combinations.
READINGS = [
    {},
    {"tangential_exponent": 0.0, "overlap_memory": "shrink", "friction_cap": "after"},
    {"tangential_exponent": 1.0, "overlap_memory": "reset"},
    {"tangential_exponent": 2.0, "overlap_memory": "shrink"},
    {"overlap_memory": "reset", "friction_cap": "after"},
]


def dense_state(seed: int, shape=(4, 3, 4)):
    """Positions, velocities, spins and radii of a disordered layer whose base touches the plane."""
    rng = np.random.default_rng(seed)
    position = lattice(shape, 1.94 * RADIUS, 0.04, rng, base=-0.97 * RADIUS)
    radius = RADIUS * rng.uniform(0.95, 1.05, len(position))
    velocity, spin = rng.normal(0, SPEED, position.shape), rng.normal(0, SPIN, position.shape)
    velocity[:, 0] += 3 * SPEED
    return position, velocity, spin, radius


def laws(**readings):
    """The laws of pairs and plane, of the engine and of the reference; frictions differ."""
    fast = [sphere_law(friction=friction, **readings) for friction in (0.4, 0.25)]
    return fast, [ContactLaw(100.0, 0.85, friction, **readings) for friction in (0.4, 0.25)]


@pytest.mark.parametrize("readings", READINGS)
def test_short_flow_equals_the_reference(readings):
    """In a cell of barely three diameters, over rebuilds of the list and openings of contacts."""
    position, velocity, spin, radius = dense_state(seed=1)
    mass, box = MASS * (radius / RADIUS) ** 3, (3.9 * 2 * RADIUS, 3.0 * 2 * RADIUS)
    (law, plane_law), (slow_law, slow_plane_law) = laws(**readings)
    motion = SphereMotion(
        position,
        velocity,
        spin,
        law=law,
        plane_law=plane_law,
        radius=radius,
        mass=mass,
        box=box,
        gravity=weight_components(17.0),
        skin=0.1 * RADIUS,
    ).run(STEPS)
    chute = slow.Chute(slow_law, slow_plane_law, box, slow.tilted(GRAVITY, 17.0))
    start = slow.Spheres(position, velocity, spin, radius, mass)
    expected = slow.run(start, chute, motion.time_step, STEPS)
    found = motion.spheres
    apart = wrapped(found.position - expected.position, *box, 0.0)
    assert np.abs(apart).max() < 1e-10 * RADIUS
    assert found.velocity == pytest.approx(expected.velocity, abs=1e-10 * SPEED)
    assert found.spin == pytest.approx(expected.spin, abs=1e-10 * SPIN)
    assert motion.flow.sums[leap_frog.CONTACTS] > 1.5 * STEPS * len(radius)
    assert np.abs(found.velocity - velocity).max() > SPEED


def test_forces_of_one_step_equal_the_reference():
    """Forces, torques, contacts, largest overlap and sums over the plane, in cells of any size."""
    for seed, shape in enumerate([(3, 3, 3), (4, 4, 2), (5, 3, 2), (6, 7, 5)]):
        position, velocity, spin, radius = dense_state(seed, shape)
        mass = MASS * (radius / RADIUS) ** 3
        box = tuple(max(3.0, 0.97 * n) * 2 * RADIUS for n in shape[:2])
        (law, plane_law), slow_laws = laws()
        options = {"law": law, "plane_law": plane_law, "box": box, "radius": radius, "mass": mass}
        motion = SphereMotion(position, velocity, spin, **options).run(1)
        start = slow.Spheres(position, velocity, spin, radius, mass)
        force, torque, contacts = slow.forces(start, slow.Chute(*slow_laws, box), motion.time_step)
        assert motion.spheres.force == pytest.approx(force, abs=1e-10 * np.abs(force).max())
        assert motion.spheres.torque == pytest.approx(torque, abs=1e-10 * np.abs(torque).max())
        on_plane = [key for key in contacts if key[1] == slow.PLANE]
        sums = motion.flow.sums
        assert sums[leap_frog.CONTACTS] == 2 * len(contacts) - len(on_plane)
        overlaps = [
            contacts[i, j].largest_overlap / (2 * radius[i] if j < 0 else radius[i] + radius[j])
            for i, j in contacts
        ]
        assert sums[leap_frog.LARGEST] == pytest.approx(max(overlaps), rel=1e-10)
        pressed = sum(contacts[key].normal_force for key in on_plane)
        dragged = sum(contacts[key].tangential_force[0] for key in on_plane)
        assert sums[leap_frog.PLANE_Z] == pytest.approx(pressed, rel=1e-10)
        assert sums[leap_frog.PLANE_X] == pytest.approx(dragged, rel=1e-10)
