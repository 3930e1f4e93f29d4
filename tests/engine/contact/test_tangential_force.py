"""Friction of one contact at a fixed normal force: stiffness, loops, memory (claim W2)."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sim.claims.contacts import contact_path
from tests.engine_motion.helpers import CAPS, EXPONENTS, sphere_law

OVERLAP = 1e-5
Z = np.array([0.0, 0.0, 1.0])


def limit_of(law) -> float:
    """Friction limit (N) at the overlap of these tests."""
    return law.limit.friction * law.loading * OVERLAP


def along_x(law, displacement) -> np.ndarray:
    """Force along x after each point of a straight path that starts at 0, at fixed overlap."""
    slip = np.zeros((len(displacement), 3))
    slip[:, 0] = np.diff(displacement, prepend=0.0)
    overlap = np.full(len(slip), OVERLAP)
    return contact_path(law, overlap, np.tile(Z, (len(slip), 1)), slip)[1][:, 0]


def displacement_of(law, drop: float, available: float) -> float:
    """Displacement over which the force changes by ``drop``, ``available`` away from sliding."""
    exponent, stiffness = law.stiffening.exponent, law.tangential
    if exponent == 1.0:
        return -available / stiffness * np.log(1 - drop / available)
    power = 1 - exponent
    return available / (power * stiffness) * (1 - (1 - drop / available) ** power)


@pytest.mark.parametrize("exponent", [*EXPONENTS, 0.5])
def test_stiffness_falls_as_the_power_of_the_distance_to_sliding(exponent):
    law = sphere_law(tangential_exponent=exponent)
    limit = limit_of(law)
    step = 1e-3 * limit / law.tangential
    force = along_x(law, step * np.arange(1, 4000))
    sticking = force[:-1] < limit * (1 - 2e-3)
    stiffness = np.diff(force) / (step * law.tangential)
    expected = np.clip(1 - force[:-1] / limit, 0, None) ** exponent
    assert np.abs(stiffness - expected)[sticking].max() < 1e-9
    assert sticking.sum() > 900
    assert (np.diff(force) >= -1e-15 * limit).all() and force.max() <= limit * (1 + 1e-14)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_force_follows_the_differential_equation_up_and_back(exponent):
    """dT/ds = K_T(T), solved by an independent integrator in the unit mu F_N, within 1e-3."""
    law = sphere_law(tangential_exponent=exponent)
    limit = limit_of(law)
    length = limit / law.tangential
    turn = 0.8 * displacement_of(law, 0.9 * limit, limit) / length

    there = np.linspace(0, turn, 4001)[1:]
    back = np.linspace(turn, -0.4 * turn, 4001)[1:]

    def solve(start, distance, sign, whole):
        def slope(_, t):
            return sign * np.clip((1 - sign * t) / whole, 0, 1) ** exponent

        span = (0, distance[-1])
        return solve_ivp(slope, span, [start], t_eval=distance, rtol=1e-9, atol=1e-12).y[0]

    up = solve(0.0, there, 1, 1.0)
    down = solve(up[-1], turn - back, -1, 1 + up[-1])
    force = along_x(law, length * np.concatenate([there, back])) / limit
    assert down[-1] < -0.1
    assert np.abs(force - np.concatenate([up, down])).max() < 1e-3


@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_loop_between_opposite_forces_closes_and_is_smooth_at_its_turning_points(share, exponent):
    law = sphere_law(tangential_exponent=exponent)
    limit, points = limit_of(law), 20_000
    peak = share * limit
    rise = displacement_of(law, peak, limit)
    width = displacement_of(law, 2 * peak, limit + peak)
    corners = np.array([0.0, rise, rise - width, rise, rise - width])
    legs = [np.linspace(a, b, points + 1)[1:] for a, b in pairwise(corners)]
    path = np.concatenate(legs)
    force = along_x(law, path) / limit
    _, down, up, again = force.reshape(4, points)
    assert force[points - 1 :: points] == pytest.approx([share, -share, share, -share], abs=1e-3)
    assert np.abs(down - again).max() < 1e-3
    assert np.abs(down + up).max() < 1e-3
    stiffness = np.abs(np.diff(up)) * limit / (law.tangential * width / points)
    assert stiffness[0] == pytest.approx(1.0, abs=5e-3)
    assert np.abs(np.diff(stiffness)).max() < 5e-3


@pytest.mark.parametrize("cap", CAPS)
def test_displacement_across_the_force_meets_the_full_stiffness(cap):
    law = sphere_law(friction_cap=cap)
    half = 0.5 * limit_of(law)
    start = displacement_of(law, half, limit_of(law))
    slip = np.zeros((2001, 3))
    slip[:-1, 0] = start / 2000
    slip[-1, 1] = 1e-3 * half / law.tangential
    force = contact_path(law, np.full(2001, OVERLAP), np.tile(Z, (2001, 1)), slip)[1]
    assert force[-2, 0] == pytest.approx(half, rel=1e-3)
    assert force[-1] - force[-2] == pytest.approx(law.tangential * slip[-1], rel=1e-9, abs=1e-18)


def test_friction_turns_with_the_tangent_plane_and_keeps_its_size():
    law = sphere_law()
    turned_force = np.array([0.6, 0.0, 0.8])
    slip = np.array([[1e-8, 0.0, 0.0], [0.0, 0.0, 0.0]])
    force = contact_path(law, np.full(2, OVERLAP), np.stack([Z, turned_force]), slip)[1]
    assert force[0] == pytest.approx([law.tangential * 1e-8, 0.0, 0.0], rel=1e-12)
    assert force[1] == pytest.approx(force[0, 0] * np.array([0.8, 0.0, -0.6]), rel=1e-12)


@pytest.mark.parametrize("cap", CAPS)
@pytest.mark.parametrize("rise", [1e-4, 1e-2, 0.3])
def test_friction_turned_at_full_sliding_keeps_its_stiffness_when_the_limit_rises(rise, cap):
    """T* then equals the limit up to rounding of either sign: Eq. 1 alone would be all noise."""
    law = sphere_law(friction_cap=cap)
    start = np.random.default_rng(0).uniform(0.5, 1.5, 200) * OVERLAP
    for overlap in start:
        loads = overlap * np.array([1.0, 0.97, 0.94, 0.94 * (1 + rise), 0.94 * (1 + rise)])
        slip = np.zeros((5, 3))
        slip[:, 0] = [1e-5, -1e-9, 1e-8, 0.0, 1e-12]
        normal, force, _ = contact_path(law, loads, np.tile(Z, (5, 1)), slip)
        assert force[2, 0] == pytest.approx(law.limit.friction * normal[2], rel=1e-12)
        gain = force[4, 0] - force[3, 0]
        assert gain == pytest.approx(law.tangential * 1e-12, rel=1e-3)


def impulse(law, steps: int) -> float:
    """Mean of T over the friction limit, over a collision whose slip turns round as it opens.

    There T, at its limit, falls with the normal force and by the slip, so it matters when it is
    cut. The slip is of the size of the overlap.
    """
    time = np.arange(1, steps) / steps
    slip = np.zeros((steps - 1, 3))
    slip[:, 0] = np.diff(OVERLAP * np.sin(0.7 * np.pi * time), prepend=0.0)
    overlap = OVERLAP * np.sin(np.pi * time)
    force = contact_path(law, overlap, np.tile(Z, (steps - 1, 1)), slip)[1][:, 0]
    return float(force.sum() / steps / limit_of(law))


@pytest.mark.parametrize(
    ("exponent", "orders"), [(0.0, {"before": 1, "after": 2}), (1 / 3, {"before": 1, "after": 1})]
)
def test_cutting_before_or_after_the_slip_is_a_matter_of_the_step_alone(exponent, orders):
    """One limit. Cutting before is of first order; after, the linear spring is of second.

    With an exponent the stiffness at the beginning of the step costs first order in both.
    """
    limits = []
    for cap, order in orders.items():
        law = sphere_law(tangential_exponent=exponent, friction_cap=cap)
        fine, finer = (impulse(law, steps) for steps in (30_000, 60_000))
        limits.append(2 * finer - fine)
        errors = [abs(impulse(law, steps) - limits[-1]) for steps in (50, 200, 800)]
        observed_order = np.log2(errors[0] / errors[2]) / 4
        assert (
            observed_order == pytest.approx(order, abs=0.25)
            if order == 1
            else observed_order > 1.75
        )
    assert limits[0] == pytest.approx(limits[1], rel=1e-5)


def impulse_of(law, steps: int, reach: float) -> float:
    """Mean friction (N) over an impact with a half sine of overlap, whose slip turns half way.

    It slips, at first, by ``reach`` times the way on which a linear spring would reach the limit.
    """
    time = (np.arange(steps) + 0.5) / steps
    slip = np.zeros((steps, 3))
    slip[:, 0] = reach * limit_of(law) / law.tangential * np.cos(np.pi * time) * np.pi / steps
    overlap = OVERLAP * np.sin(np.pi * time)
    return contact_path(law, overlap, np.tile(Z, (steps, 1)), slip)[1][:, 0].mean()


@pytest.mark.parametrize("cap", CAPS)
@pytest.mark.parametrize("reach", [0.9, 9])
def test_friction_of_an_impact_converges_with_the_step_whenever_the_limit_is_applied(cap, reach):
    """Both readings of the limit are of first order in the step, and the same without one."""
    law = sphere_law(friction_cap=cap)
    exact = impulse_of(sphere_law(friction_cap="after"), 80_000, reach)
    errors = [abs(impulse_of(law, steps, reach) / exact - 1) for steps in (40, 160, 640)]
    assert errors[2] < 0.005
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(4, abs=2)
