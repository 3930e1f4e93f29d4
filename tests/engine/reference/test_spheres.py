"""What the slow reference says of single contacts of spheres, by hand."""

import numpy as np
import pytest

from tests.engine.reference.chute import (
    PLANE,
    Chute,
    Spheres,
    collision_time,
    run,
    surface_velocity,
)
from tests.engine.reference.walton_braun import (
    Contact,
    ContactLaw,
    length,
    normal,
    softening,
    tangential,
    update,
)
from tests.engine_motion.helpers import CAPS, MASS, MEMORIES, RADIUS

Z = np.array([0.0, 0.0, 1.0])
NORMAL_FORCE = 1e-3


def law(**changes) -> ContactLaw:
    base = {"stiffness": 100.0, "restitution": 0.85, "friction": 0.4}
    return ContactLaw(**{**base, **changes})


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


@pytest.mark.parametrize("memory", MEMORIES)
def test_overlap_memory_decides_how_a_forceless_contact_loads_again(memory):
    spring = law(overlap_memory=memory)
    peak, k1, k2 = 1e-5, spring.stiffness, spring.unloading_stiffness
    rest = (1 - spring.restitution**2) * peak
    _, largest = normal(peak, 0.5 * rest, spring)
    overlap = 0.5 * rest + 1e-8
    expected = {"separation": 0.0, "shrink": k2 * 1e-8, "reset": k1 * overlap}[memory]
    assert normal(largest, overlap, spring)[0] == pytest.approx(expected, rel=1e-9, abs=1e-18)


@pytest.mark.parametrize("memory", MEMORIES)
def test_separation_forgets_everything(memory):
    spring = law(overlap_memory=memory)
    slip = np.array([1e-6, 0.0, 0.0])
    _, _, contact = update(Contact(), 1e-5, Z, slip, spring)
    force, shear, contact = update(contact, 0.0, Z, slip, spring)
    assert force == 0.0 and not shear.any()
    assert update(contact, 1e-6, Z, slip, spring)[0] == spring.stiffness * 1e-6


def test_force_is_turned_with_the_tangent_plane_and_keeps_its_size():
    contact = Contact(np.array([3e-5, 0.0, 0.0]), normal_force=NORMAL_FORCE)
    k_hat = np.array([0.6, 0.0, 0.8])
    turned = tangential(contact, NORMAL_FORCE, k_hat, np.zeros(3), law()).tangential_force
    assert turned == pytest.approx(3e-5 * np.array([0.8, 0.0, -0.6]), rel=1e-12)
    lost = Contact(3e-5 * Z, normal_force=NORMAL_FORCE)
    assert not tangential(lost, NORMAL_FORCE, Z, np.zeros(3), law()).tangential_force.any()


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


def pair(position, velocity, spin) -> Spheres:
    """Two equal spheres."""
    rows = (np.array(each, float) for each in (position, velocity, spin))
    return Spheres(*rows, np.full(2, RADIUS), np.full(2, MASS))


def test_rolling_surfaces_do_not_slip():
    rest = np.zeros((2, 3))
    ball = pair([[0, 0, RADIUS], [1, 1, 1]], [[0.05, 0, 0], [0, 0, 0]], rest)
    ball.spin[0, 1] = 0.05 / RADIUS
    assert length(surface_velocity(ball, 0, PLANE, np.array([0, 0, -1.0]))) < 1e-16
    gears = pair([[0, 0, 0], [2 * RADIUS, 0, 0]], rest, [[0, 3, 7], [0, -3, -7]])
    assert length(surface_velocity(gears, 0, 1, np.array([1.0, 0, 0]))) == 0.0


@pytest.mark.parametrize("exponent", [0.0, 1 / 3])
def test_oblique_impacts_converge_with_the_time_step_and_both_caps_to_one_result(exponent):
    """Cutting T before the displacement leaves an error of first order in the time step."""

    def outcome(cap: str, steps: int) -> float:
        law_ = law(friction_cap=cap, tangential_exponent=exponent)
        time_step = collision_time(law_, MASS) / steps
        apart = 2 * RADIUS + 0.3 * 0.02 * time_step
        moving = [[0.01, -0.02, 0], [-0.01, 0.02, 0]]
        start = pair([[0, 0, 0], [apart, 0, 0]], moving, np.zeros((2, 3)))
        end = run(start, Chute(law_), time_step, int(1.5 * steps))
        return float(end.velocity[1, 1]) / 0.02

    finest = {cap: outcome(cap, 800) for cap in CAPS}
    assert finest["before"] == pytest.approx(finest["after"], abs=3e-3)
    for cap, tolerance in (("before", 0.03), ("after", 0.005)):
        errors = [abs(outcome(cap, steps) / finest[cap] - 1) for steps in (40, 160)]
        assert errors[0] < tolerance and errors[1] < 0.5 * tolerance
