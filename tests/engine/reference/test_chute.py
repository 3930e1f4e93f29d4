"""Exact results for one and two spheres, with and without the plane."""

import numpy as np
import pytest

from .chute import (
    PLANE,
    Chute,
    Spheres,
    collision_time,
    cross,
    nearest_image,
    run,
    step,
    surface_velocity,
    tilted,
)
from .walton_braun import ContactLaw, length

RADIUS, MASS, GRAVITY = 0.5e-3, 1.492e-6, 9.8
EXPONENTS = [0.0, 1 / 3, 1.0, 2.0]
SPEEDS = [1e-3, 1e-2, 1e-1, 1.0]


def law(**changes) -> ContactLaw:
    base = {"stiffness": 100.0, "restitution": 0.85, "friction": 0.4}
    return ContactLaw(**{**base, **changes})


def spheres(position, velocity, spin=None) -> Spheres:
    """Equal spheres, without spin unless it is given."""
    position = np.array(position, dtype=float)
    spin = np.zeros_like(position) if spin is None else np.array(spin, dtype=float)
    count = len(position)
    return Spheres(
        position,
        np.array(velocity, dtype=float),
        spin,
        np.full(count, RADIUS),
        np.full(count, MASS),
    )


def plane(contact_law: ContactLaw, angle: float = 0.0, gravity: float = GRAVITY) -> Chute:
    return Chute(contact_law, contact_law, None, tilted(gravity, angle))


def resting(contact_law: ContactLaw, angle: float, speed: float, spin: float) -> Spheres:
    """A sphere in normal equilibrium on the plane with a speed along x and a spin about y."""
    overlap = MASS * GRAVITY * np.cos(np.radians(angle)) / contact_law.stiffness
    return spheres([[0, 0, RADIUS - overlap]], [[speed, 0, 0]], [[0, spin, 0]])


def struck_pair(speed: float, time_step: float, slide: float = 0.0) -> Spheres:
    """Two spheres 0.3 steps before they touch, approaching along x and sliding along y."""
    gap = 0.3 * speed * time_step
    return spheres(
        [[0, 0, 0], [2 * RADIUS + gap, 0, 0]],
        [[0.5 * speed, -0.5 * slide, 0], [-0.5 * speed, 0.5 * slide, 0]],
    )


def energy(body: Spheres) -> float:
    """Kinetic energy with that of the spins, J."""
    inertia = 0.4 * body.mass * body.radius**2
    translation = np.sum(body.mass[:, None] * body.velocity**2)
    return float(0.5 * (translation + np.sum(inertia[:, None] * body.spin**2)))


def momentum(body: Spheres) -> np.ndarray:
    return np.sum(body.mass[:, None] * body.velocity, axis=0)


def angular_momentum(body: Spheres) -> np.ndarray:
    """About the origin, with the spins."""
    inertia = 0.4 * body.mass * body.radius**2
    orbital = body.mass[:, None] * np.cross(body.position, body.velocity)
    return np.sum(orbital + inertia[:, None] * body.spin, axis=0)


# Normal impacts (claim W1)


def pair_restitution(contact_law: ContactLaw, speed: float, steps_per_collision: int = 40) -> float:
    time_step = collision_time(contact_law, MASS) / steps_per_collision
    pair = struck_pair(speed, time_step)
    pair = run(pair, Chute(contact_law), time_step, 3 * steps_per_collision)
    assert not pair.contacts
    return float(pair.velocity[1, 0] - pair.velocity[0, 0]) / speed


def plane_restitution(contact_law: ContactLaw, speed: float) -> float:
    time_step = collision_time(contact_law, MASS) / 40
    body = spheres([[0, 0, RADIUS + 0.3 * speed * time_step]], [[0, 0, -speed]])
    body = run(body, plane(contact_law, gravity=0.0), time_step, 120)
    assert not body.contacts
    return float(body.velocity[0, 2]) / speed


@pytest.mark.parametrize("memory", ["separation", "shrink"])
@pytest.mark.parametrize("restitution", [0.5, 0.7, 0.85, 0.95, 1.0])
@pytest.mark.parametrize("measure", [pair_restitution, plane_restitution])
def test_restitution_is_the_root_of_the_stiffness_ratio_at_every_speed(
    measure, restitution, memory
):
    """The rest of the error comes from the time step and scales out of the speed."""
    contact_law = law(restitution=restitution, overlap_memory=memory)
    found = np.array([measure(contact_law, speed) for speed in SPEEDS])
    assert np.abs(found - restitution).max() < 1e-3
    assert np.ptp(found) < 1e-6


def test_reset_memory_raises_the_restitution():
    """A contact that forgets at zero force pushes again while it opens.

    Each forgotten overlap a leaves the overlap (1 - e^2) a behind, which loads afresh: the energy
    returned is the sum of a geometric series and the restitution 1/sqrt(2 - e^2).
    """
    contact_law = law(overlap_memory="reset")
    expected = 1 / np.sqrt(2 - contact_law.restitution**2)
    errors = [expected - pair_restitution(contact_law, 0.01, n) for n in (200, 400, 800)]
    assert 0 < errors[2] < 2e-3
    assert errors[0] > errors[1] > errors[2]


def test_a_later_collision_of_the_pair_starts_afresh():
    contact_law = law()
    time_step = collision_time(contact_law, MASS) / 40
    chute = Chute(contact_law)
    used = run(struck_pair(0.02, time_step, 0.02), chute, time_step, 60)
    assert not used.contacts
    again = struck_pair(0.02, time_step, 0.02)
    again.contacts = used.contacts
    first = run(struck_pair(0.02, time_step, 0.02), chute, time_step, 60)
    assert np.array_equal(run(again, chute, time_step, 60).velocity, first.velocity)


# Rolling and slipping


def test_rolling_surfaces_do_not_slip():
    ball = spheres([[0, 0, RADIUS]], [[0.05, 0, 0]], [[0, 0.05 / RADIUS, 0]])
    assert length(surface_velocity(ball, 0, PLANE, np.array([0, 0, -1.0]))) < 1e-16
    gears = spheres([[0, 0, 0], [2 * RADIUS, 0, 0]], np.zeros((2, 3)), [[0, 3, 7], [0, -3, -7]])
    assert length(surface_velocity(gears, 0, 1, np.array([1.0, 0, 0]))) == 0.0


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_rolling_sphere_feels_no_tangential_force(exponent):
    contact_law = law(tangential_exponent=exponent)
    ball = resting(contact_law, 0.0, 0.05, 0.05 / RADIUS)
    chute, time_step = plane(contact_law), collision_time(contact_law, MASS) / 40
    for _ in range(300):
        ball = step(ball, chute, time_step)
        assert length(ball.contacts[0, PLANE].tangential_force) < 1e-12 * MASS * GRAVITY
    assert ball.velocity[0, 0] == pytest.approx(0.05, rel=1e-13)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_sliding_sphere_slows_by_friction_then_rolls_at_five_sevenths(exponent):
    """v + (2/5) r w is conserved exactly; the slip ends in a tangential oscillation about zero."""
    contact_law = law(tangential_exponent=exponent)
    speed, time_step = 0.05, collision_time(contact_law, MASS) / 40
    chute = plane(contact_law)
    duration = 2 / 7 * speed / (contact_law.friction * GRAVITY)
    sliding_steps = int(0.9 * duration / time_step)
    ball = run(resting(contact_law, 0.0, speed, 0.0), chute, time_step, sliding_steps)
    slowed = (speed - ball.velocity[0, 0]) / (sliding_steps * time_step)
    assert slowed == pytest.approx(contact_law.friction * GRAVITY, rel=1e-9)
    ball = run(ball, chute, time_step, sliding_steps)
    invariant = ball.velocity[0, 0] + 0.4 * RADIUS * ball.spin[0, 1]
    assert invariant == pytest.approx(speed, rel=1e-12)
    assert ball.velocity[0, 0] == pytest.approx(5 / 7 * speed, rel=0.01)
    assert RADIUS * ball.spin[0, 1] == pytest.approx(5 / 7 * speed, rel=0.03)


@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize("friction", [0.05, 0.08, 0.1, 0.4])
def test_lone_sphere_slips_or_rolls_down_the_incline(friction, exponent):
    angle = 17.0
    contact_law = law(friction=friction, tangential_exponent=exponent)
    time_step = collision_time(contact_law, MASS) / 40
    down, _, into = tilted(GRAVITY, angle)
    slips = friction < 2 / 7 * np.tan(np.radians(angle))
    expected = down + friction * into if slips else 5 / 7 * down
    start = 0.05 / RADIUS * (0.8 if slips else 1.0)
    ball = resting(contact_law, angle, 0.05, start)
    ball = run(ball, plane(contact_law, angle), time_step, 300)
    before = ball.velocity[0, 0]
    ball = run(ball, plane(contact_law, angle), time_step, 1500)
    found = (ball.velocity[0, 0] - before) / (1500 * time_step)
    assert found == pytest.approx(expected, rel=1e-9 if slips else 5e-3)


@pytest.mark.parametrize("cap", ["before", "after"])
@pytest.mark.parametrize("exponent", [0.0, 1 / 3])
def test_gross_slip_impact(exponent, cap):
    """The tangential surface velocity falls by 3.5 (1 + e) mu v_n."""
    contact_law = law(tangential_exponent=exponent, friction_cap=cap)
    time_step = collision_time(contact_law, MASS) / 40
    impact, slide = 0.02, 0.12
    start = [[0, 0, RADIUS + 0.3 * impact * time_step]]
    ball = spheres(start, [[slide, 0, -impact]])
    ball = run(ball, plane(contact_law, gravity=0.0), time_step, 120)
    restitution = ball.velocity[0, 2] / impact
    surface = ball.velocity[0, 0] - RADIUS * ball.spin[0, 1]
    expected = 3.5 * (1 + restitution) * contact_law.friction * impact
    assert slide - surface == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_softer_contacts_fall_short_of_gross_slip(exponent):
    """Equation 1 approaches a rising limit from below: T lags behind mu F_N while F_N grows.

    With s = mu K1 v_n/(K0 v_t) the lag is of the order s^(1/exponent), so it fades with faster
    slip; it is a property of the law and does not fade with the time step.
    """
    contact_law = law(tangential_exponent=exponent)
    time_step = collision_time(contact_law, MASS) / 40
    impact, shortfall = 0.02, []
    for ratio in (4, 16, 64):
        start = [[0, 0, RADIUS + 0.3 * impact * time_step]]
        ball = spheres(start, [[ratio * impact, 0, -impact]])
        ball = run(ball, plane(contact_law, gravity=0.0), time_step, 120)
        fall = ratio * impact - (ball.velocity[0, 0] - RADIUS * ball.spin[0, 1])
        slipping = 3.5 * (impact + ball.velocity[0, 2]) * contact_law.friction
        shortfall.append(1 - fall / slipping)
    assert 0.2 > shortfall[0] > shortfall[1] >= shortfall[2] - 1e-12


# Conservation and symmetry


def cluster() -> Spheres:
    """Four spheres of unequal size and mass that collide with slip and spin."""
    rng = np.random.default_rng(3)
    corners = 0.48e-3 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])
    radius = RADIUS * np.array([1.0, 1.3, 1.2, 1.4])
    velocity = -200 * corners + 0.01 * rng.normal(size=(4, 3))
    spin = 20.0 * rng.normal(size=(4, 3))
    return Spheres(corners, velocity, spin, radius, MASS * (radius / RADIUS) ** 3)


def test_free_spheres_conserve_momentum_and_lose_energy():
    body, chute = cluster(), Chute(law())
    time_step = collision_time(law(), MASS) / 40
    before, scale = momentum(body), np.sum(body.mass) * 0.01
    after = run(body, chute, time_step, 150)
    assert energy(after) < energy(body)
    assert np.abs(momentum(after) - before).max() < 1e-12 * scale


def test_angular_momentum_changes_only_by_the_overlap():
    """Torques act at the full radii, centres are closer than that by the overlap.

    So each contact adds overlap * k_hat x T to the total, and nothing else does.
    """
    body, chute = cluster(), Chute(law())
    time_step = collision_time(law(), MASS) / 40
    expected = angular_momentum(body)
    scale = float(np.abs(expected).max())
    drift = np.zeros(3)
    for _ in range(150):
        after = step(body, chute, time_step)
        for (i, j), contact in after.contacts.items():
            separation = body.position[j] - body.position[i]
            overlap = body.radius[i] + body.radius[j] - length(separation)
            arm = overlap * separation / length(separation)
            drift += time_step * cross(arm, contact.tangential_force)
        body = after
        assert np.abs(angular_momentum(body) - expected - drift).max() < 1e-11 * scale
    assert 0 < np.abs(drift).max() < 0.05 * scale


def test_oblique_impacts_never_gain_energy():
    rng = np.random.default_rng(11)
    for exponent in EXPONENTS:
        contact_law = law(tangential_exponent=exponent)
        time_step = collision_time(contact_law, MASS) / 40
        for _ in range(10):
            pair = struck_pair(0.02, time_step, 0.04 * rng.uniform(-1, 1))
            pair.spin = 20.0 * rng.normal(size=(2, 3))
            after = run(pair, Chute(contact_law), time_step, 60)
            assert energy(after) < energy(pair)


def test_collision_in_a_turned_frame_is_the_turned_collision():
    rng = np.random.default_rng(5)
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    frame *= np.linalg.det(frame)
    time_step = collision_time(law(), MASS) / 40
    pair = struck_pair(0.02, time_step, 0.015)
    pair.spin = 5.0 * rng.normal(size=(2, 3))
    turned = spheres(pair.position @ frame.T, pair.velocity @ frame.T, pair.spin @ frame.T)
    pair = run(pair, Chute(law()), time_step, 60)
    turned = run(turned, Chute(law()), time_step, 60)
    assert turned.velocity == pytest.approx(pair.velocity @ frame.T, abs=1e-10)
    assert turned.spin == pytest.approx(pair.spin @ frame.T, abs=1e-7)


def test_collision_across_the_edges_is_the_collision_inside():
    time_step = collision_time(law(), MASS) / 40
    box = (5e-3, 4e-3)
    pair = struck_pair(0.02, time_step, 0.015)
    inside = run(pair, Chute(law(), box=box), time_step, 60)
    shifted = pair.position + np.array([[0, 0, 0], [5 * box[0], -3 * box[1], 0]])
    across = run(spheres(shifted, pair.velocity), Chute(law(), box=box), time_step, 60)
    assert across.velocity == pytest.approx(inside.velocity, abs=1e-10)
    assert nearest_image(np.array([3e-3, -2.5e-3, 9e-3]), box) == pytest.approx(
        [-2e-3, 1.5e-3, 9e-3]
    )


@pytest.mark.parametrize(("cap", "tolerance"), [("before", 0.03), ("after", 0.005)])
def test_oblique_impact_converges_with_the_time_step(cap, tolerance):
    """Cutting T before the displacement leaves an error of first order in the time step."""
    contact_law = law(friction_cap=cap)

    def outcome(steps_per_collision: int) -> float:
        time_step = collision_time(contact_law, MASS) / steps_per_collision
        pair = struck_pair(0.02, time_step, 0.04)
        pair = run(pair, Chute(contact_law), time_step, int(1.5 * steps_per_collision))
        return float(pair.velocity[1, 1]) / 0.02

    finest = outcome(800)
    errors = [abs(outcome(steps) / finest - 1) for steps in (40, 160)]
    assert errors[0] < tolerance and errors[1] < 0.5 * tolerance
