"""The loop over steps of the spheres against the slow reference, from dense random states."""

import numpy as np
import pytest

from sim.engine.contact import Partners, law_of
from sim.engine.contact.friction import turning_numbers
from sim.engine.contact.spring_dashpot import spring_dashpot
from sim.engine.systems import leap_frog
from tests.engine.reference import chute as slow
from tests.engine.reference.laws import ContactLaw, SpringDashpotLaw
from tests.engine_motion.helpers import (
    GRAVITY,
    LAWS,
    MASS,
    RADIUS,
    lattice,
    sphere_law,
    weight_components,
    wrapped,
)
from tests.engine_motion.motion import SphereMotion
from tests.engine_motion.points import chute_point

STEPS = 80
SPEED, SPIN = 0.05, 100.0


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


def run_both(law_pairs, base: float, threads: int = 1, orientations: bool = False, time_step=None):
    """A dense layer after STEPS steps, its start, and what the reference makes of the same start.

    ``both`` are laws as from ``laws``. The cell is barely three diameters wide; the layer's lowest
    spheres are at ``base`` (m).
    """
    position, velocity, spin, radius = dense_state(seed=1)
    position[:, 2] += base
    mass, box = MASS * (radius / RADIUS) ** 3, (3.9 * 2 * RADIUS, 3.0 * 2 * RADIUS)
    (law, plane_law), slow_laws = law_pairs
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
        threads=threads,
        orientations=orientations,
        time_step=time_step,
    ).run(STEPS)
    chute = slow.Chute(*slow_laws, box, slow.tilted(GRAVITY, 17.0))
    start = slow.Spheres(position, velocity, spin, radius, mass)
    return motion, start, slow.run(start, chute, motion.time_step, STEPS)


def check(motion, start, expected) -> None:
    """Demand that the engine agrees with the reference, memory of all contacts included."""
    difference = wrapped(motion.position - expected.position, *motion.length)
    assert np.abs(difference).max() < 1e-10 * RADIUS
    assert motion.velocity == pytest.approx(expected.velocity, abs=1e-10 * SPEED)
    assert motion.spin == pytest.approx(expected.spin, abs=1e-10 * SPIN)
    i, j, _, memory = motion.contacts()
    back = np.where(np.arange(len(memory)) < (turning := turning_numbers(motion.laws[0])), -1, 1)
    memories = {
        (min(a, b), max(a, b)): column if a < b else back * column
        for a, b, column in zip(i.tolist(), j.tolist(), memory.T, strict=True)
    }
    resting, memory = motion.plane_contacts()
    memories |= {
        (a, slow.PLANE): column for a, column in zip(resting.tolist(), memory.T, strict=True)
    }
    assert memories.keys() == expected.contacts.keys()
    load = max(contact.normal_force for contact in expected.contacts.values())
    for key, contact in expected.contacts.items():
        assert memories[key][:3] == pytest.approx(contact.tangential_force, abs=1e-10 * load)
        if turning > 3:
            assert memories[key][3:6] == pytest.approx(contact.spring, abs=1e-10 * load)
        if contact.largest_overlap:
            assert memories[key][6] == pytest.approx(contact.largest_overlap, abs=1e-10 * RADIUS)
    assert motion.flow.sums[leap_frog.CONTACTS] > 1.5 * STEPS * len(start.radius)
    assert np.abs(motion.velocity - start.velocity).max() > SPEED


@pytest.mark.parametrize("base", [0.0, 10 * RADIUS], ids=["on the plane", "free"])
@pytest.mark.parametrize("readings", LAWS)
def test_short_flow_equals_the_reference(readings, base):
    """Over rebuilds of the list and openings of contacts, from random spins."""
    motion, start, expected = run_both(laws(**readings), base)
    check(motion, start, expected)
    assert bool(motion.plane_contacts()[0].size) == (base == 0.0)


@pytest.mark.parametrize("base", [0.0, 10 * RADIUS], ids=["on the plane", "free"])
@pytest.mark.parametrize("attraction", ["kept", pytest.param("clipped", marks=pytest.mark.long)])
def test_short_flow_of_springs_and_dashpots_equals_the_reference(base, attraction):
    step = 2e-6
    values = [
        (100.0, 0.7, 0.4, 0.5 * MASS, step, 0.8, attraction),
        (100.0, 0.85, 0.25, MASS, step, 0.5, attraction),
    ]
    law_pairs = [spring_dashpot(*v) for v in values], [SpringDashpotLaw(*v) for v in values]
    check(*run_both(law_pairs, base, time_step=step))


@pytest.mark.parametrize("attraction", ["kept", "clipped"])
@pytest.mark.parametrize("damping", [{"restitution": 0.7}, {"normal_damping": 2000}])
def test_short_flow_of_any_masses_and_drag_along_surfaces_equals_the_reference(attraction, damping):
    step, values = 2e-6, {"attraction": attraction, "tangential_damping": 1500, **damping}
    point = chute_point(law="spring_dashpot", stiffness=100.0, tangential_ratio=0.8, **values)
    fast = [law_of(point, Partners(friction, 0.0, step)) for friction in (0.4, 0.25)]
    values = {"restitution": 1.0, **values}
    slow_laws = [
        SpringDashpotLaw(100.0, friction=friction, mass=0.0, time_step=step, **values)
        for friction in (0.4, 0.25)
    ]
    check(*run_both((fast, slow_laws), 0.0, time_step=step))


@pytest.mark.parametrize("threads", [2, 7])
def test_short_flow_of_any_number_of_threads_equals_the_reference(threads):
    check(*run_both(laws(), 0.0, threads, orientations=True))


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
        assert motion.force == pytest.approx(force, abs=1e-10 * np.abs(force).max())
        assert motion.torque == pytest.approx(torque, abs=1e-10 * np.abs(torque).max())
        on_plane = [key for key in contacts if key[1] == slow.PLANE]
        sums = motion.flow.sums
        assert sums[leap_frog.CONTACTS] == 2 * len(contacts) - len(on_plane)
        overlaps = [
            contacts[i, j].largest_overlap / (2 * radius[i] if j < 0 else radius[i] + radius[j])
            for i, j in contacts
        ]
        assert sums[leap_frog.LARGEST] == pytest.approx(max(overlaps), rel=1e-10)
        normal_sum = sum(contacts[key].normal_force for key in on_plane)
        friction_sum = sum(contacts[key].tangential_force[0] for key in on_plane)
        assert sums[leap_frog.PLANE_Z] == pytest.approx(normal_sum, rel=1e-10)
        assert sums[leap_frog.PLANE_X] == pytest.approx(friction_sum, rel=1e-10)
