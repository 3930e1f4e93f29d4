"""Laws along the path of one contact: the slow reference, and exact results of Walton and Braun's.

Of the latter: the hysteretic normal force, friction at a fixed normal force (claim W2), exponent 0
against an independent vector spring (claim W3), and which way the friction of a sliding contact
points. Where T = μ F_N slides, the printed recipe turns it by dφ/ds = -K0 sin φ/(μ F_N), φ its
angle with the slip s, so tan(φ/2) falls as exp(-K0 s/(μ F_N)).
"""

from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sim.claims.experiments import contact_path, random_curve, vector_spring
from sim.engine.contact.friction import SMALLEST
from sim.engine.contact.spring_dashpot import spring_dashpot
from tests.engine.reference.laws import Contact, ContactLaw, SpringDashpotLaw, update
from tests.engine_motion.helpers import (
    CONTACT_LAWS,
    LAWS,
    MASS,
    READINGS,
    cube_roots,
    dissipated_energy,
    inverse_square_roots,
    sphere_law,
)
from tests.engine_motion.points import chute_point, series_of

STEPS = 400


def history(seed: int, slip_size: float):
    """Overlaps (n,), normals (n, 3) and slips (n, 3) of a contact that opens now and then."""
    rng = np.random.default_rng(seed)
    overlap = 1e-5 * (0.8 + 0.9 * np.sin(rng.normal(0, 0.15, STEPS).cumsum()))
    normal = rng.normal(0, 0.02, (STEPS, 3)).cumsum(axis=0)
    normal[:, 2] += 1.0
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    slip = slip_size * np.sin(rng.normal(0, 0.3, (STEPS, 3)).cumsum(axis=0))
    slip -= (slip * normal).sum(axis=1)[:, None] * normal
    return overlap, normal, slip


def closed_stretches(overlap):
    """Slices of the history during which the contact is closed."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], overlap > 0, [0]])))
    return [slice(a, b) for a, b in edges.reshape(-1, 2)]


@pytest.mark.parametrize(
    "readings", [*CONTACT_LAWS, *(pytest.param(one, marks=pytest.mark.long) for one in READINGS)]
)
def test_law_equals_the_reference(readings):
    law, slow = sphere_law(**readings), ContactLaw(100.0, 0.85, 0.4, **readings)
    scale = 0.4 * law.loading * 1e-5
    for seed, slip_size in product(range(2), (1e-8, 2e-7, 2e-6)):
        overlap, normal, slip = history(seed, slip_size)
        for closed in closed_stretches(overlap):
            path = contact_path(law, overlap[closed], normal[closed], slip[closed])
            contact = Contact()
            steps = zip(overlap[closed], normal[closed], slip[closed], *path, strict=True)
            for gap, k_hat, ds, force, friction, memory_now in steps:
                expected, shear, contact = update(contact, gap, k_hat, ds, slow)
                assert abs(force - expected) < 1e-12 * scale
                assert np.abs(friction - shear).max() < 1e-10 * scale
                assert abs(memory_now[3] - np.linalg.norm(shear)) < 1e-10 * scale
                assert abs(memory_now[4] * force - contact.turning_point) < 1e-10 * scale
                assert memory_now[5] == (contact.sense < 0)
                assert abs(memory_now[6] - contact.largest_overlap) < 1e-12 * 1e-5


@pytest.mark.parametrize("attraction", ["kept", "clipped"])
def test_springs_and_dashpots_equal_the_reference(attraction):
    """The reference takes the approach from the slip."""
    values = (100.0, 0.7, 0.4, 0.5 * MASS, 2e-6, 0.8, attraction)
    law, slow, pulls = spring_dashpot(*values), SpringDashpotLaw(*values), 0
    for seed, slip_size in product(range(2), (1e-8, 2e-7, 2e-6)):
        overlap, normal, slip = history(seed, slip_size)
        for closed in closed_stretches(overlap):
            path = contact_path(law, overlap[closed], normal[closed], slip[closed])
            contact, before = Contact(), 0.0
            steps = zip(overlap[closed], normal[closed], slip[closed], *path[:2], strict=True)
            for gap, k_hat, ds, force, friction in steps:
                moved = ds - (gap - before) * k_hat
                expected, shear, contact = slow.update(contact, gap, k_hat, moved)
                assert abs(force - expected) < 1e-12 * 1e-5 * law.damping
                assert np.abs(friction - shear).max() < 1e-10 * 1e-5 * law.damping
                before, pulls = gap, pulls + (force < 0)
    assert bool(pulls) == (attraction == "kept")


def test_histories_visit_sticking_sliding_reversal_and_forceless_contact():
    """What the comparison above is worth: the branches of the law that its paths reach."""
    law, visits = sphere_law(), np.zeros(5, int)
    for slip_size in (1e-8, 2e-7, 2e-6):
        overlap, normal, slip = history(0, slip_size)
        visits[0] += (overlap <= 0).sum()
        for closed in closed_stretches(overlap):
            path = contact_path(law, overlap[closed], normal[closed], slip[closed])
            force, friction, memory_now = path
            size = np.linalg.norm(friction, axis=1)
            visits[1] += ((size > 0.4 * force * (1 - 1e-9)) & (force > 0)).sum()
            visits[2] += (size < 0.39 * force).sum()
            visits[3] += (memory_now[:, 5] == 1).sum()
            visits[4] += (force == 0).sum()
    assert visits.min() > 20


PEAK = 1e-5


def normal_forces(law, overlaps) -> np.ndarray:
    """Normal force (n,) along overlaps (n,) > 0, without slip."""
    overlap = np.array(overlaps, float)
    normal = np.tile([0.0, 0.0, 1.0], (overlap.size, 1))
    return contact_path(law, overlap, normal, np.zeros_like(normal))[0]


def rest_overlap(law) -> float:
    """Overlap at which the force falls to zero after a peak overlap of PEAK."""
    return (1.0 - law.loading / law.unloading) * PEAK


@pytest.mark.parametrize("restitution", [0.3, 0.85, 1.0])
@pytest.mark.parametrize("readings", LAWS)
def test_force_loads_along_k1_and_unloads_and_reloads_along_k2(readings, restitution):
    law = sphere_law(restitution=restitution, **readings)
    rest = rest_overlap(law)
    rising = np.linspace(0.01, 1.0, 50) * PEAK
    falling = np.linspace(PEAK, 1.001 * rest + 1e-3 * PEAK, 50)
    again = np.linspace(falling[-1], 1.5 * PEAK, 80)
    force = normal_forces(law, np.concatenate([rising, falling, again]))
    assert force[:50] == pytest.approx(law.loading * rising, rel=1e-12)
    assert force[50:100] == pytest.approx(law.unloading * (falling - rest), rel=1e-9)
    expected = np.minimum(law.unloading * (again - rest), law.loading * again)
    assert force[100:] == pytest.approx(expected, rel=1e-9)
    assert law.loading / law.unloading == pytest.approx(restitution**2, rel=1e-14)
    path = np.concatenate([np.linspace(0, PEAK, 5001)[1:], np.linspace(PEAK, 0, 5001)[1:-1]])
    if readings["overlap_memory"] == "separation":
        expected = 0.5 * law.loading * PEAK**2 * (1 - restitution**2)
        loss = np.trapezoid(normal_forces(law, path), path)
        assert loss == pytest.approx(expected, abs=1e-3 * law.loading * PEAK**2)
        assert dissipated_energy(law, path) == pytest.approx(expected, rel=1e-9, abs=1e-20)


@pytest.mark.parametrize("readings", LAWS)
def test_a_contact_without_force_loads_again_as_its_memory_says(readings):
    """Below the dent, separation stays without force, shrink pushes along K2, reset along K1."""
    law = sphere_law(**readings)
    low, rise = 0.5 * rest_overlap(law), 0.01 * PEAK
    force = normal_forces(law, [PEAK, low, low + rise])
    assert force[1] == 0.0
    expected = {
        "separation": 0.0,
        "shrink": law.unloading * rise,
        "reset": law.loading * (low + rise),
    }
    assert force[2] == pytest.approx(expected[readings["overlap_memory"]], rel=1e-9, abs=1e-18)


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


@pytest.mark.parametrize("readings", [*LAWS, LAWS[2] | {"tangential_exponent": 2.0}])
def test_force_follows_the_differential_equation_up_and_back(readings):
    """dT/ds = K_T(T), solved by an independent integrator in the unit mu F_N, within 1e-3."""
    law, exponent = sphere_law(**readings), readings["tangential_exponent"]
    limit = limit_of(law)
    length = limit / law.tangential
    turn = {0.0: 0.7, 1 / 3: 0.9, 1.0: 1.8, 2.0: 7.0}[exponent]
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


@pytest.mark.parametrize("rise", [1e-4, 1e-2, 0.3])
def test_friction_turned_at_full_sliding_keeps_its_stiffness_when_the_limit_rises(rise):
    """T* then equals the limit up to rounding of either sign: Eq. 1 alone would be all noise."""
    law = sphere_law()
    start = np.random.default_rng(0).uniform(0.5, 1.5, 200) * OVERLAP
    for overlap in start:
        loads = overlap * np.array([1.0, 0.97, 0.94, 0.94 * (1 + rise), 0.94 * (1 + rise)])
        slip = np.zeros((5, 3))
        slip[:, 0] = [1e-5, -1e-9, 1e-8, 0.0, 1e-12]
        normal, force, _ = contact_path(law, loads, np.tile(Z, (5, 1)), slip)
        assert force[2, 0] == pytest.approx(law.limit.friction * normal[2], rel=1e-12)
        gain = force[4, 0] - force[3, 0]
        assert gain == pytest.approx(law.tangential * 1e-12, rel=1e-3)


FORCE = 1e-3
PATHS = range(40)


def compare_springs(law, seed: int, steps: int, swing: float):
    """Engine and spring along one path: differences, limit and forces of the spring, in N, (n,).

    An elastic law makes the normal force proportional to the overlap, so any F_N can be had.
    """
    path = 3.0 * law.limit.friction * FORCE / law.tangential * random_curve(seed, steps)
    slip = np.zeros((steps, 3))
    slip[:, :2] = np.diff(path, axis=0)
    normal_force = FORCE * np.exp(swing * random_curve(seed + 1000, steps)[1:, 0])
    normal = np.tile([0.0, 0.0, 1.0], (steps, 1))
    _, force, _ = contact_path(law, normal_force / law.loading, normal, slip)
    friction = law.limit.friction
    expected = vector_spring(slip[:, :2].copy(), normal_force, law.tangential, friction)
    difference = np.linalg.norm(force[:, :2] - expected, axis=1)
    return difference, friction * normal_force, np.linalg.norm(expected, axis=1)


@pytest.mark.parametrize("readings", LAWS[1:])
def test_the_vector_spring_is_met_exactly(readings):
    """With exponent 0, at a constant normal force, and with the cap after at one that varies."""
    law, sliding = sphere_law(restitution=1.0, **readings), []
    law = law._replace(stiffening=type(law.stiffening)(0.0))
    is_cut_after = readings["friction_cap"] == "after"
    for seed, swing in product(PATHS, (0.0, 0.7) if is_cut_after else (0.0,)):
        difference, limit, size = compare_springs(law, seed, 1000, swing)
        assert (difference < 1e-12 * limit).all()
        sliding.append(np.mean(size > (1 - 1e-9) * limit))
    assert 0.1 < np.mean(sliding) < 0.9


START = np.radians(60.0)


def angles(sliding: str, step: float, steps: int) -> np.ndarray:
    """Angles (S,) of the friction with a slip along x, of ``step`` μ F_N/K0 each.

    Before it the contact has slipped far at the angle START.
    """
    law = sphere_law(sliding_direction=sliding)
    scale = law.limit.friction * law.loading * OVERLAP / law.tangential
    earlier_slip = np.tile([np.cos(START), np.sin(START), 0.0], (40, 1))
    slip = scale * np.concatenate([0.5 * earlier_slip, np.tile([step, 0.0, 0.0], (steps, 1))])
    normal = np.tile(Z, (len(slip), 1))
    _, friction, _ = contact_path(law, np.full(len(slip), OVERLAP), normal, slip)
    return np.arctan2(friction[40:, 1], friction[40:, 0])


@pytest.mark.parametrize("sliding", ["printed", "slip"])
def test_short_slips_turn_it_as_the_equation_says(sliding):
    errors = []
    for step in (0.1, 0.05, 0.025):
        slips = step * np.arange(1, round(2 / step) + 1)
        expected = 2 * np.arctan(np.tan(START / 2) * np.exp(-slips))
        errors.append(np.abs(angles(sliding, step, len(slips)) - expected).max())
    assert errors[0] < 0.05
    assert errors[1:] == pytest.approx([errors[0] / 2, errors[0] / 4], rel=0.1)


@pytest.mark.parametrize("step", [3.0, 30.0, 3000.0])
def test_it_settles_along_long_slips_but_as_printed(step):
    assert np.abs(angles("slip", step, 20)[-1]) < 1e-6
    assert np.abs(angles("printed", step, 20)[-5:]).min() > 0.1


@pytest.mark.parametrize(
    ("sliding", "ratio"), [("printed", 0.08), pytest.param("slip", 0.1, marks=pytest.mark.long)]
)
def test_what_a_flow_that_slides_feels_at_the_plane(sliding, ratio):
    """The coefficient of friction; as printed about three quarters of it."""
    point = chute_point(
        depth=2, cell=4, angle=20, friction_plane=0.1, sliding_direction=sliding,
        transient=60, average=20, steps_per_collision=20,
    )  # fmt: skip
    series = {name: values[-60:] for name, values in series_of(point).items()}
    coefficient = series["base_shear_force"].mean() / series["base_normal_force"].mean()
    assert coefficient == pytest.approx(ratio, rel=0.03 if sliding == "slip" else 0.15)


LARGE = 1e290
BOUNDS = [(SMALLEST, 1e-200), (1e-200, 1.0), (1e-16, 1.0), (1e-3, 1.0), (1.0, 8.0), (1.0, LARGE)]


def samples(low: float, high: float) -> np.ndarray:
    """Numbers from low to high, evenly and at random over their logarithm."""
    even = np.geomspace(low, high, 100_001)
    random = np.random.default_rng(1).uniform(np.log(low), np.log(high), 100_000)
    return np.concatenate([even[1:], np.exp(random[random > np.log(SMALLEST) + 1e-9])])


@pytest.mark.parametrize(("low", "high"), BOUNDS)
def test_roots_are_right_to_two_and_one_units_in_the_fifteenth_digit(low, high):
    x = samples(low, high)
    assert np.abs(cube_roots(x) / np.cbrt(x) - 1.0).max() < 2e-15
    assert np.abs(inverse_square_roots(x) * np.sqrt(x) - 1.0).max() < 1e-15


def test_cube_roots_of_zero_and_one_are_those_of_sliding_and_of_a_fresh_contact():
    roots = cube_roots(np.array([0.0, 1e-310, 0.99 * SMALLEST, 1.0]))
    assert np.array_equal(roots[:3], np.zeros(3))
    assert roots[3] == pytest.approx(1.0, abs=1e-15)
    assert np.isnan(inverse_square_roots(np.array([np.nan]))).all()
