"""Exact results of the contact law itself: one contact, prescribed overlaps and displacements."""

import itertools

import numpy as np
import pytest

from .walton_braun import Contact, ContactLaw, length, normal, softening, tangential, update

Z = np.array([0.0, 0.0, 1.0])
EXPONENTS = [0.0, 1 / 3, 1.0, 2.0]
NORMAL_FORCE = 1e-3


def law(**changes) -> ContactLaw:
    base = {"stiffness": 100.0, "restitution": 0.85, "friction": 0.4}
    return ContactLaw(**{**base, **changes})


def sliding_length(contact_law: ContactLaw) -> float:
    """Displacement at which a linear spring reaches the friction limit."""
    return contact_law.friction * NORMAL_FORCE / contact_law.tangential_stiffness


def along_x(path: np.ndarray, contact_law: ContactLaw) -> np.ndarray:
    """Force along x after each point of a straight path at constant normal force."""
    contact = Contact(normal_force=NORMAL_FORCE)
    found = [0.0]
    for displacement in np.diff(path):
        slip = np.array([displacement, 0.0, 0.0])
        contact = tangential(contact, NORMAL_FORCE, Z, slip, contact_law)
        found.append(contact.tangential_force[0])
    return np.array(found)


def in_plane(path: np.ndarray, normal_force: np.ndarray, contact_law: ContactLaw) -> np.ndarray:
    """Force in the plane after each point of a path (n, 2), normal forces (n,)."""
    contact = Contact(normal_force=normal_force[0])
    found = [np.zeros(2)]
    for displacement, force in zip(np.diff(path, axis=0), normal_force[1:], strict=True):
        contact = tangential(contact, force, Z, np.append(displacement, 0.0), contact_law)
        found.append(contact.tangential_force[:2])
    return np.array(found)


def cundall_strack(
    path: np.ndarray, normal_force: np.ndarray, stiffness: float, friction: float
) -> np.ndarray:
    """A linear vector spring whose force is cut to the friction limit after each displacement."""
    force, found = np.zeros(2), [np.zeros(2)]
    for start, end, limit in zip(path[:-1], path[1:], friction * normal_force[1:], strict=True):
        force = force + stiffness * (end - start)
        if np.hypot(*force) > limit:
            force = limit * force / np.hypot(*force)
        found.append(force)
    return np.array(found)


def random_curve(seed: int, steps: int, scale: float) -> np.ndarray:
    """A smooth closed random curve (steps + 1, 2) that starts at the origin."""
    rng = np.random.default_rng(seed)
    sines, cosines = rng.normal(size=(2, 5, 2))
    mode = np.arange(1, 6)
    angle = 2.0 * np.pi * np.linspace(0.0, 1.0, steps + 1)[:, None] * mode
    return scale * (np.sin(angle) @ (sines / mode[:, None]) + (np.cos(angle) - 1) @ cosines)


# Normal force


def test_normal_force_follows_its_three_branches():
    spring = law()
    peak, k1, k2 = 1e-5, spring.stiffness, spring.unloading_stiffness
    rest = (1 - spring.restitution**2) * peak
    force, memory = normal(0.0, peak, spring)
    assert (force, memory) == (k1 * peak, peak)
    for overlap in (0.9 * peak, 0.6 * peak, 1.1 * rest):
        force, memory = normal(memory, overlap, spring)
        assert force == pytest.approx(k2 * (overlap - rest), rel=1e-12)
    assert normal(memory, 0.9 * rest, spring) == (0.0, peak)
    assert normal(memory, 2 * peak, spring) == (k1 * 2 * peak, 2 * peak)


def test_elastic_contact_unloads_along_the_loading_line():
    assert normal(2e-5, 1e-5, law(restitution=1.0))[0] == pytest.approx(100.0 * 1e-5, rel=1e-15)


@pytest.mark.parametrize("memory", ["separation", "shrink", "reset"])
def test_overlap_memory_decides_how_a_forceless_contact_loads_again(memory):
    spring = law(overlap_memory=memory)
    peak, k1, k2 = 1e-5, spring.stiffness, spring.unloading_stiffness
    rest = (1 - spring.restitution**2) * peak
    _, largest = normal(peak, 0.5 * rest, spring)
    overlap = 0.5 * rest + 1e-8
    expected = {"separation": 0.0, "shrink": k2 * 1e-8, "reset": k1 * overlap}[memory]
    assert normal(largest, overlap, spring)[0] == pytest.approx(expected, rel=1e-9, abs=1e-18)


@pytest.mark.parametrize("memory", ["separation", "shrink", "reset"])
def test_separation_forgets_everything(memory):
    spring = law(overlap_memory=memory)
    slip = np.array([1e-6, 0.0, 0.0])
    _, _, contact = update(Contact(), 1e-5, Z, slip, spring)
    force, shear, contact = update(contact, 0.0, Z, slip, spring)
    assert force == 0.0 and not shear.any()
    assert update(contact, 1e-6, Z, slip, spring)[0] == spring.stiffness * 1e-6


def test_no_normal_force_means_no_tangential_force():
    slip = np.array([1e-6, 0.0, 0.0])
    _, shear, contact = update(Contact(), 1e-5, Z, slip, law())
    assert shear[0] > 0.0
    force, shear, contact = update(contact, 1e-7, Z, slip, law())
    assert force == 0.0 and not shear.any()
    assert (contact.turning_point, contact.sense, contact.largest_overlap) == (0.0, 1, 1e-5)


# Tangential force, one step


def test_force_is_turned_with_the_tangent_plane_and_keeps_its_size():
    contact = Contact(np.array([3e-5, 0.0, 0.0]), normal_force=NORMAL_FORCE)
    k_hat = np.array([0.6, 0.0, 0.8])
    turned = tangential(contact, NORMAL_FORCE, k_hat, np.zeros(3), law()).tangential_force
    assert turned == pytest.approx(3e-5 * np.array([0.8, 0.0, -0.6]), rel=1e-12)
    lost = Contact(3e-5 * Z, normal_force=NORMAL_FORCE)
    assert not tangential(lost, NORMAL_FORCE, Z, np.zeros(3), law()).tangential_force.any()


def test_displacement_along_the_normal_is_ignored():
    slip = np.array([1e-8, 2e-8, 5e-6])
    found = tangential(Contact(), NORMAL_FORCE, Z, slip, law()).tangential_force
    assert found == pytest.approx(80.0 * np.array([1e-8, 2e-8, 0.0]), rel=1e-12)


def test_frictionless_contact_has_no_tangential_force():
    slip = np.array([1e-6, 1e-6, 0.0])
    for cap in ("before", "after"):
        assert not update(Contact(), 1e-5, Z, slip, law(friction=0.0, friction_cap=cap))[1].any()


def test_turning_point_scales_with_the_normal_force():
    contact = Contact(np.array([1e-4, 0, 0]), 8e-5, -1, normal_force=NORMAL_FORCE)
    slip = np.array([-1e-9, 0.0, 0.0])
    found = tangential(contact, 2 * NORMAL_FORCE, Z, slip, law())
    assert found.turning_point == pytest.approx(1.6e-4, rel=1e-12)
    assert tangential(Contact(np.array([1e-4, 0, 0]), 8e-5), 1e-3, Z, slip, law()).sense == -1


@pytest.mark.parametrize("back", [1.0, -1.0])
def test_displacement_across_the_force_meets_the_full_stiffness(back):
    contact = Contact(np.array([2e-4, 0.0, 0.0]), normal_force=NORMAL_FORCE)
    slip = np.array([back * 1e-8, 3e-8, 0.0])
    softened = 0.5 ** (1 / 3) if back > 0 else 1.0
    found = tangential(contact, NORMAL_FORCE, Z, slip, law()).tangential_force
    expected = [2e-4 + 80.0 * softened * back * 1e-8, 80.0 * 3e-8, 0.0]
    assert found == pytest.approx(expected, rel=1e-12)


def test_friction_cap_before_and_after_the_displacement():
    """A fall of the normal force leaves T above the limit; the surfaces slip back a little."""
    contact = Contact(np.array([4e-4, 0.0, 0.0]), normal_force=NORMAL_FORCE)
    slip = np.array([-1e-7, 0.0, 0.0])
    limit = 0.4 * 0.9 * NORMAL_FORCE
    before = tangential(contact, 0.9 * NORMAL_FORCE, Z, slip, law(friction_cap="before"))
    after = tangential(contact, 0.9 * NORMAL_FORCE, Z, slip, law(friction_cap="after"))
    assert before.tangential_force[0] == pytest.approx(limit - 80.0 * 1e-7, rel=1e-12)
    assert after.tangential_force[0] == pytest.approx(limit, rel=1e-12)
    assert (before.turning_point, after.turning_point) == pytest.approx((limit, 4e-4), rel=1e-12)


def test_softening_is_guarded_where_the_denominator_vanishes():
    linear, rounding = law(tangential_exponent=0.0), 1e-16
    for turning_point in (1.0 - rounding, 1.0, 1.0 + rounding, 1.5):
        for magnitude in (1.0 - rounding, 1.0, 1.0 + rounding):
            assert softening(magnitude, turning_point, 1, 1.0, law()) == 0.0
            assert softening(magnitude, turning_point, 1, 1.0, linear) == 1.0
        assert softening(0.9, turning_point, 1, 1.0, law()) == 1.0


def test_softening_is_equation_one():
    friction_limit, exponent = 2.0, 1 / 3
    rising = (1 - (1.2 - -0.5) / (friction_limit - -0.5)) ** exponent
    falling = (1 - (1.5 - 0.2) / (friction_limit + 1.5)) ** exponent
    assert softening(1.2, -0.5, 1, friction_limit, law()) == pytest.approx(rising, rel=1e-14)
    assert softening(0.2, 1.5, -1, friction_limit, law()) == pytest.approx(falling, rel=1e-14)


@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize("cap", ["before", "after"])
def test_random_histories_stay_in_the_plane_below_the_limit_in_any_frame(exponent, cap):
    spring = law(tangential_exponent=exponent, friction_cap=cap)
    rng = np.random.default_rng(7)
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    here, there = Contact(), Contact()
    for _ in range(400):
        k_hat = Z + 0.05 * rng.normal(size=3)
        k_hat /= length(k_hat)
        overlap = 1e-5 * (1 + 0.5 * rng.uniform(-1, 1))
        slip = 3e-7 * rng.normal(size=3)
        force, shear, here = update(here, overlap, k_hat, slip, spring)
        _, turned, there = update(there, overlap, frame @ k_hat, frame @ slip, spring)
        assert length(shear) <= 0.4 * force * (1 + 1e-12)
        assert abs(np.dot(shear, k_hat)) < 1e-12 * spring.stiffness * overlap
        assert turned == pytest.approx(frame @ shear, abs=1e-9 * spring.stiffness * overlap)


# Tangential force along a line (claim W2)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_stiffness_falls_to_zero_at_full_sliding(exponent):
    spring = law(tangential_exponent=exponent)
    step = 1e-3 * sliding_length(spring)
    force = along_x(step * np.arange(3000), spring)
    limit = spring.friction * NORMAL_FORCE
    below = force[:-1] < limit - spring.tangential_stiffness * step
    stiffness = np.diff(force) / step / spring.tangential_stiffness
    expected = (1.0 - force[:-1] / limit) ** exponent
    assert np.abs(stiffness - expected)[below].max() < 1e-9
    assert np.all(np.diff(force) >= -1e-15 * limit) and force.max() <= limit * (1 + 1e-12)
    if exponent < 1.0:
        assert force[-1] == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_stiffness_passes_smoothly_through_the_reversal_of_the_force(exponent):
    """From T = T1 backwards one formula holds with a signed T, on both sides of T = 0."""
    spring = law(tangential_exponent=exponent)
    limit, step = spring.friction * NORMAL_FORCE, 1e-3 * sliding_length(spring)
    there = step * np.arange(800)
    back = there[-1] - step * np.arange(1, 1800)
    force = along_x(np.concatenate([there, back]), spring)[799:]
    turning_point = force[0]
    stiffness = -np.diff(force) / step / spring.tangential_stiffness
    base = 1.0 - (turning_point - force[:-1]) / (limit + turning_point)
    sticking = np.abs(force[:-1]) < limit - spring.tangential_stiffness * step
    assert force[-1] < -0.3 * limit
    assert np.abs(stiffness - base**exponent)[sticking].max() < 1e-8
    assert stiffness[0] == pytest.approx(1.0, rel=1e-9)


def unloaded(drop: float, available: float, spring: ContactLaw) -> float:
    """Displacement that lowers the force by drop after a turning point, from equation 1."""
    k0, exponent = spring.tangential_stiffness, spring.tangential_exponent
    if exponent == 1.0:
        return -available / k0 * np.log(1.0 - drop / available)
    power = 1.0 - exponent
    return available / (power * k0) * (1.0 - (1.0 - drop / available) ** power)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_loop_between_two_opposite_forces_closes(exponent):
    """Turned at T = +-T1 the loop closes on itself; its width follows from equation 1."""
    spring = law(tangential_exponent=exponent)
    limit = spring.friction * NORMAL_FORCE
    peak = 0.6 * limit
    rise = unloaded(peak, limit, spring)
    width = unloaded(2 * peak, limit + peak, spring)
    errors = []
    for points in (500, 1000):
        corners = [0.0, rise, rise - width, rise, rise - width, rise]
        legs = [np.linspace(a, b, points + 1) for a, b in itertools.pairwise(corners)]
        path = np.concatenate([legs[0], *(leg[1:] for leg in legs[1:])])
        turns = along_x(path, spring)[points::points]
        errors.append(np.abs(turns / peak - np.array([1, -1, 1, -1, 1])).max())
    assert errors[1] < 5e-3
    if exponent == 0.0:
        assert errors[1] < 1e-12
    else:
        assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_loop_between_two_displacements_settles_after_a_few_cycles(exponent):
    """Below full sliding the law is not of Masing's kind: cycles at fixed displacement shake down
    to a symmetric loop instead of closing at once."""
    spring = law(tangential_exponent=exponent)
    reach, points = sliding_length(spring), 100
    cycle = reach * np.abs((np.arange(4 * points) + points) % (4 * points) - 2 * points) / points
    path = np.concatenate([np.tile(reach - cycle, 12), [0.0]])
    turns = along_x(path, spring)[points :: 2 * points]
    assert turns[-1] == pytest.approx(-turns[-2], rel=2e-3)
    assert abs(turns[0]) >= abs(turns[2]) * (1 - 1e-12)


# A zero exponent against the linear vector spring (claim W3)


@pytest.mark.parametrize("cap", ["before", "after"])
def test_zero_exponent_is_the_linear_spring_at_constant_normal_force(cap):
    spring = law(tangential_exponent=0.0, friction_cap=cap)
    normal_force = np.full(301, NORMAL_FORCE)
    limit = spring.friction * NORMAL_FORCE
    for seed in range(100):
        path = random_curve(seed, 300, 2 * sliding_length(spring))
        expected = cundall_strack(path, normal_force, spring.tangential_stiffness, spring.friction)
        assert np.abs(in_plane(path, normal_force, spring) - expected).max() < 1e-12 * limit
        assert np.isclose(np.hypot(*expected.T), limit).any()


def varying(seed: int, steps: int, spring: ContactLaw) -> tuple[float, float]:
    """Largest difference from the linear spring and largest K0 |ds|, both over mu F_N."""
    path = random_curve(seed, steps, 2 * sliding_length(spring))
    force = NORMAL_FORCE * np.exp(0.5 * random_curve(seed + 1000, steps, 1.0)[:, 0])
    expected = cundall_strack(path, force, spring.tangential_stiffness, spring.friction)
    difference = in_plane(path, force, spring) - expected
    step = spring.tangential_stiffness * np.hypot(*np.diff(path, axis=0).T)
    return (
        float((np.hypot(*difference.T) / (spring.friction * force)).max()),
        float(step.max() / (spring.friction * force.min())),
    )


def test_zero_exponent_is_the_linear_spring_at_varying_normal_force_if_capped_after():
    spring = law(tangential_exponent=0.0, friction_cap="after")
    assert max(varying(seed, 300, spring)[0] for seed in range(30)) < 1e-12


def test_cap_before_differs_from_the_linear_spring_by_one_step_at_most():
    """Only where F_N falls on a sliding contact, and only by the K0 |ds| of a step.

    The linear spring with its single cut at the end keeps mu F_N while the surfaces slip back
    less than the limit falls; cutting first loses K0 |ds| below the limit. So the two agree in the
    limit of small steps, to first order.
    """
    spring = law(tangential_exponent=0.0, friction_cap="before")
    for seed in range(8):
        coarse, step = varying(seed, 400, spring)
        fine, _ = varying(seed, 800, spring)
        assert coarse < step
        assert coarse / fine == pytest.approx(2.0, rel=0.3)
