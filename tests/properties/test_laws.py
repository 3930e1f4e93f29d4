"""What holds for the contact laws whatever their parameters, their scales and their history."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.contact.spring_damping import spring_damping
from sim.contact.walton_braun import walton_braun
from tests.engine_helpers import (
    CAPS,
    EXPONENTS,
    MEMORIES,
    contact_path,
    disk_forces,
    rotation,
    vector_spring,
)

STEPS = 200
Z = np.array([0.0, 0.0, 1.0])

seeds = st.integers(0, 2**32 - 1)
signs = st.sampled_from([-1.0, 1.0])


def magnitudes(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers of all magnitudes from 10**low to 10**high."""
    return st.floats(low, high).map(lambda power: 10.0**power)


#: Readings of the law of the spheres, each of which the other tests compile too.
READINGS = st.fixed_dictionaries(
    {
        "tangential_exponent": st.sampled_from(EXPONENTS),
        "overlap_memory": st.sampled_from(MEMORIES),
        "friction_cap": st.sampled_from(CAPS),
    }
)


@st.composite
def sphere_laws(draw, decades=3, readings=READINGS):
    """Laws of the spheres with a stiffness around 1 N/m, and any friction and restitution."""
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


def norms(vectors) -> np.ndarray:
    return np.linalg.norm(vectors, axis=1)


@given(sphere_laws(decades=12), seeds, magnitudes(-12, 12), magnitudes(-6, 3))
def test_spheres_repel_and_rub_within_the_limit_at_all_magnitudes(law, seed, length, slip):
    overlap, normal, slips = history(law, seed, length, slip)
    force, friction, memory = contact_path(law, overlap, normal, slips)
    assert np.isfinite(memory).all() and np.isfinite(friction).all()
    assert (force >= 0.0).all()
    assert (force <= law.loading * overlap * (1 + 1e-12)).all()
    limit = law.limit.friction * force
    assert (norms(friction) <= limit * (1 + 1e-12)).all()
    assert (np.abs((friction * normal).sum(axis=1)) <= 1e-9 * limit.max()).all()


@given(sphere_laws(), seeds, magnitudes(-6, 0), magnitudes(-3, 1))
def test_partners_that_change_places_feel_the_opposite_friction(law, seed, length, slip):
    overlap, normal, slips = history(law, seed, length, slip)
    force, friction, memory = contact_path(law, overlap, normal, slips)
    other_force, other_friction, other_memory = contact_path(law, overlap, -normal, -slips)
    assert np.array_equal(other_force, force)
    assert np.array_equal(other_friction, -friction)
    assert np.array_equal(other_memory[:, 3:], memory[:, 3:])


def same_friction(found, expected, limit) -> bool:
    """Whether two frictions (n, 3) agree but for rounding, which the exponents may magnify."""
    return bool((norms(found - expected) <= 1e-7 * limit.max()).all())


@given(sphere_laws(), seeds, magnitudes(-6, 0), magnitudes(-3, 1))
def test_friction_turns_with_the_frame(law, seed, length, slip):
    overlap, normal, slips = history(law, seed, length, slip)
    force, friction, _ = contact_path(law, overlap, normal, slips)
    frame = rotation(np.random.default_rng(seed))
    turned = contact_path(law, overlap, normal @ frame.T, slips @ frame.T)[1]
    assert same_friction(turned, friction @ frame.T, law.limit.friction * force)


@given(sphere_laws(), seeds, magnitudes(-3, 1), magnitudes(-6, 6), magnitudes(-6, 6))
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


def exact_cycle(law, peaks) -> np.ndarray:
    """Overlaps from 0 over turning points and back to 0, with all corners of the force between.

    The force is linear between them, so that a trapezoid gives the work exactly.
    """
    path, deepest = [0.0], 0.0
    for target in (*peaks, 0.0):
        corners = [law.dent.slope * deepest, deepest]
        low, high = sorted((path[-1], target))
        between = sorted((c for c in corners if low < c < high), reverse=target < path[-1])
        path += [*between, target]
        deepest = max(deepest, target)
    return np.array(path)


@given(
    sphere_laws(readings=st.just({"overlap_memory": "separation"})),
    st.lists(st.floats(1e-3, 1), min_size=1, max_size=20),
)
def test_no_cycle_of_overlap_gives_energy(law, peaks):
    """What comes back of the work of a cycle is at most e**2 of the deepest loading."""
    overlap = exact_cycle(law, peaks)
    force = contact_path(law, overlap, np.tile(Z, (overlap.size, 1)), np.zeros((overlap.size, 3)))[
        0
    ]
    work = np.concatenate([[0], np.cumsum(np.diff(overlap) * (force[1:] + force[:-1]) / 2)])
    loading = law.loading * max(peaks) ** 2 / 2
    rounding = 1e-9 * loading * len(peaks)
    assert work.min() >= -rounding
    lost = loading * (1 - law.loading / law.unloading)
    assert work[-1] >= lost - rounding


@given(
    sphere_laws(readings=st.just({})),
    magnitudes(-9, 3),
    magnitudes(-9, 3),
    magnitudes(-3, 3),
)
def test_an_impact_of_spheres_has_the_restitution_e_at_any_mass_and_speed(law, mass, other, speed):
    """The motion whose force is m* times its acceleration leaves at e times its first speed."""
    reduced = mass * other / (mass + other)
    restitution = np.sqrt(law.loading / law.unloading)
    rate = np.sqrt(law.loading / reduced)
    phase = np.linspace(0, np.pi / 2, 201)
    peak = speed / rate
    rest = (1 - restitution**2) * peak
    approach, retreat = peak * np.sin(phase[1:]), rest + (peak - rest) * np.cos(phase[1:])
    deceleration = np.concatenate(
        [rate**2 * approach, (rate / restitution) ** 2 * (retreat - rest)]
    )
    overlap = np.concatenate([approach, retreat])
    force = contact_path(law, overlap, np.tile(Z, (400, 1)), np.zeros((400, 3)))[0]
    assert np.abs(force - reduced * deceleration).max() <= 1e-9 * law.loading * peak
    leaving = (peak - rest) * rate / restitution
    assert leaving == pytest.approx(restitution * speed, rel=1e-9)


@given(
    st.sampled_from(CAPS),
    magnitudes(-3, 6),
    magnitudes(-2, 1),
    magnitudes(-3, 2),
    seeds,
    magnitudes(-3, 1),
)
def test_exponent_0_is_the_linear_spring(cap, stiffness, friction, ratio, seed, slip):
    law = walton_braun(stiffness, 1.0, friction, ratio, 0.0, friction_cap=cap)
    slips = np.zeros((STEPS, 3))
    limit = friction * stiffness * 1e-5
    slips[:, :2] = (
        slip * limit / law.tangential * np.random.default_rng(seed).normal(size=(STEPS, 2))
    )
    found = contact_path(law, np.full(STEPS, 1e-5), np.tile(Z, (STEPS, 1)), slips)[1]
    force = np.full(STEPS, stiffness * 1e-5)
    expected = vector_spring(slips[:, :2].copy(), force, law.tangential, friction)
    assert norms(found[:, :2] - expected).max() <= 1e-10 * limit
    assert not found[:, 2].any()


@given(
    st.sampled_from(EXPONENTS),
    st.lists(st.tuples(signs, magnitudes(-2, 0.5)), min_size=1, max_size=10),
)
def test_friction_gives_back_no_more_than_was_put_in(exponent, turns):
    """Work on a fresh contact along a line, at constant F_N, in units of the limit squared / K0."""
    law = walton_braun(100.0, 1.0, 0.4, tangential_exponent=exponent)
    limit = 0.4 * 100.0 * 1e-5
    corners = [0.0, *(sign * size for sign, size in turns)]
    path = np.concatenate([np.linspace(a, b, 401)[1:] for a, b in itertools.pairwise(corners)])
    slips = np.zeros((path.size, 3))
    slips[:, 0] = limit / law.tangential * np.diff(path, prepend=0.0)
    overlap = np.full(path.size, 1e-5)
    force = contact_path(law, overlap, np.tile(Z, (path.size, 1)), slips)[1][:, 0] / limit
    mean = (force + np.concatenate([[0.0], force[:-1]])) / 2
    assert (mean * np.diff(path, prepend=0.0)).cumsum().min() >= -1e-3


@st.composite
def bead_contacts(draw, decades=3):
    """Y (N/m), γ and γ_s (1/s), and overlap, normal, velocity and masses of 50 contacts."""
    rng = np.random.default_rng(draw(seeds))
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


ATTRACTIONS = st.sampled_from(["kept", "clipped"])
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


@given(bead_contacts(), ATTRACTIONS)
def test_beads_that_change_places_feel_the_opposite_force_if_the_mass_is_reduced(
    contacts, attraction
):
    law, overlap, normal, velocity, mass, other = contacts
    reduced = spring_damping(**law, damping_mass="reduced", attraction=attraction)
    here = disk_forces(reduced, overlap, normal, velocity, mass, 1 / other)
    there = disk_forces(reduced, overlap, -normal, -velocity, other, 1 / mass)
    damped = mass * other / (mass + other)
    size = sum(map(norms, parts(law, damped, overlap, normal, velocity)))
    assert (norms(here + there) <= 1e-12 * size).all()


@given(bead_contacts(), MASSES, ATTRACTIONS)
def test_beads_lose_energy_in_the_frame_of_the_pair(contacts, damping_mass, attraction):
    """Beside the spring, both forces work against the relative motion."""
    law, overlap, normal, velocity, mass, other = contacts
    compiled = spring_damping(**law, damping_mass=damping_mass, attraction=attraction)
    here = disk_forces(compiled, overlap, normal, velocity, mass, 1 / other)
    there = disk_forces(compiled, overlap, -normal, -velocity, other, 1 / mass)
    spring = law["stiffness"] * overlap[:, None] * normal
    power = ((here + spring) * velocity).sum(axis=1) - ((there - spring) * velocity).sum(axis=1)
    size = (norms(here) + norms(there) + norms(spring)) * norms(velocity)
    assert (power <= 1e-12 * size).all()


@given(bead_contacts(), MASSES, ATTRACTIONS, seeds)
def test_forces_of_beads_turn_with_the_frame(contacts, damping_mass, attraction, seed):
    law, overlap, normal, velocity, mass, other = contacts
    compiled = spring_damping(**law, damping_mass=damping_mass, attraction=attraction)
    force = disk_forces(compiled, overlap, normal, velocity, mass, 1 / other)
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    turned = disk_forces(compiled, overlap, normal @ turn, velocity @ turn, mass, 1 / other)
    size = sum(map(norms, parts(law, mass, overlap, normal, velocity)))
    assert (norms(turned - force @ turn) <= 1e-12 * size).all()


@given(bead_contacts(), MASSES, ATTRACTIONS, st.tuples(*[magnitudes(-6, 6)] * 3))
def test_forces_of_beads_scale_with_length_time_and_mass(
    contacts, damping_mass, attraction, scales
):
    law, overlap, normal, velocity, mass, other = contacts
    length, time, weight = scales
    readings = {"damping_mass": damping_mass, "attraction": attraction}
    force = disk_forces(
        spring_damping(**law, **readings), overlap, normal, velocity, mass, 1 / other
    )
    scaled = spring_damping(
        law["stiffness"] * weight / time**2,
        law["damping"] / time,
        law["shear_damping"] / time,
        **readings,
    )
    speeds = length / time * velocity
    found = disk_forces(scaled, length * overlap, normal, speeds, weight * mass, 1 / weight / other)
    unit = weight * length / time**2
    size = sum(map(norms, parts(law, mass, overlap, normal, velocity)))
    assert (norms(found / unit - force) <= 1e-12 * size).all()


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
