"""Values that follow from parameters: defaults, lengths, SI, words, damping of a restitution."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sim.parameters import SYSTEMS, BeltParameters, ChuteParameters, in_si, parse_point, point_id
from sim.parameters.dashpot import contact_time, damping_fraction, restitution_of, time_of
from sim.parameters.words import setting


def test_defaults_that_follow_other_parameters_and_natural_units_of_the_chute():
    assert ChuteParameters(friction=0.2).friction_plane == 0.2
    assert ChuteParameters(friction=0.2, friction_plane=0.6).friction_plane == 0.6
    assert [ChuteParameters(depth=depth).cell for depth in (1, 10, 10.5, 40)] == [10, 10, 5, 5]
    assert ChuteParameters(depth=40).initial_velocity == 30
    assert ChuteParameters(depth=2.5).initial_velocity == 7
    chute = ChuteParameters()
    assert chute.time_unit == pytest.approx(10.10e-3, rel=1e-3)
    assert chute.velocity_unit == pytest.approx(0.0990, rel=1e-3)
    assert chute.particles == 500
    assert chute.steps_per_collision * chute.time_step == pytest.approx(
        math.pi / 2 * math.sqrt(1.492e-6 / 2 / 100) * 1.85
    )


def spring_time(p: ChuteParameters) -> float:
    """Return how long two particles oscillate on a spring K1 with a drag, half a period, s."""
    damped = math.hypot(1, math.log(p.restitution) / math.pi)
    return math.pi * math.sqrt(p.mass / 2 / p.stiffness) * damped


def hertz_time(p: ChuteParameters) -> float:
    """Return how long an impact of Hertz' spheres at 10 √(gσ) lasts, s."""
    overlap, radius, speed = p.diameter / 100, p.diameter / 4, 10 * p.velocity_unit
    modulus = p.stiffness * overlap / (4 / 3 * math.sqrt(radius) * overlap**1.5)
    return 2.87 * ((p.mass / 2) ** 2 / (radius * modulus**2 * speed)) ** 0.2


@pytest.mark.parametrize(
    ("law", "time"),
    [
        ("walton_braun", lambda p: math.pi / 2 * math.sqrt(p.mass / 2 / p.stiffness) * 1.6),
        ("spring_dashpot", spring_time),
        ("drag", spring_time),
        ("hertz", hertz_time),
    ],
)
def test_the_shortest_collision_is_that_of_the_law(law, time):
    chute = ChuteParameters(law=law, restitution=0.6, stiffness=300)
    assert chute.collision_time == pytest.approx(time(chute), rel=1e-12)


def test_a_damping_stands_in_the_place_of_the_restitution():
    """With Silbert's numbers, in units of his spheres: e = 0.88 in the bulk, 0.84 on the base."""
    given = {"law": "spring_dashpot", "diameter": 1, "mass": 1, "gravity": 1, "stiffness": 2e5}
    point = parse_point({"system": "chute", **given, "normal_damping": 50}, "point")
    assert point_id(point).startswith("chute-depth5-friction0.4-stiffness200000-law-spring_dashpot")
    found = [f"{restitution:.3f}" for restitution in point.restitutions.values()]
    assert found == ["0.883", "0.839"]
    assert parse_point({"system": "chute", **given}, "point").restitutions == {}
    clipped = given | {"attraction": "clipped", "normal_damping": 895}
    assert 0 < min(parse_point({"system": "chute", **clipped}, "point").restitutions.values()) < 0.2


def test_lengths_of_runs():
    chute = ChuteParameters(transient=10, average=5)
    interval = chute.sample_steps * chute.time_step
    assert interval == pytest.approx(0.25 * chute.time_unit, rel=0.01)
    assert chute.transient_samples * interval == pytest.approx(10 * chute.time_unit, rel=0.02)
    assert chute.average_samples * interval == pytest.approx(5 * chute.time_unit, rel=0.02)
    assert chute.steps == (chute.transient_samples + chute.average_samples) * chute.sample_steps
    # Those of the belt are the paper's.
    belt = BeltParameters()
    assert belt.time_step == pytest.approx(1 / (2000 * 20))
    assert belt.transient_samples * belt.sample_steps == 90_000
    assert belt.average_samples * belt.sample_steps == 90_000
    assert belt.steps == 180_000
    # The shortest run has a sample, the smallest cell a particle.
    chute = ChuteParameters(depth=1e-6, transient=0, average=0.25)
    assert (chute.particles, chute.transient_samples, chute.average_samples) == (1, 0, 1)


def test_a_trajectory_has_at_least_one_frame_and_is_not_too_large():
    chute = ChuteParameters(trajectory=1, transient=300, average=200, replicates=2)
    assert (chute.trajectory_samples, chute.trajectory_bytes) == (4, 2 * 500 * 500 * 9 * 4)
    belt = BeltParameters(trajectory=1e-3, beads=100)
    assert (belt.trajectory_samples, belt.trajectory_bytes) == (1, 90 * 20 * 100 * 4 * 4)
    assert ChuteParameters().trajectory_samples == ChuteParameters().trajectory_bytes == 0
    assert ChuteParameters(trajectory=500).trajectory_bytes == 500 * 9 * 4
    large = {"system": "chute", "depth": 40, "cell": 20, "average": 4700}
    assert 1.9e9 < parse_point(large | {"trajectory": 1.5}, "point.yaml").trajectory_bytes < 2e9


def test_damping_follows_the_stiffness_where_the_restitution_is_held():
    assert BeltParameters(stiffness=4000).normal_damping == 500
    reading = {"stiffness_keeps": "restitution"}
    assert BeltParameters(stiffness=4000, **reading).normal_damping == pytest.approx(1000)
    assert BeltParameters(**reading).normal_damping == 500
    soft, hard = (BeltParameters(stiffness=y, shear_damping=0, **reading) for y in (1000, 9000))
    assert soft.settling_step / hard.settling_step == pytest.approx(3)


@pytest.mark.parametrize(
    ("readings", "lowest"),
    [
        *(({}, 15.1), ({"damping_mass": "reduced"}, 9.8), ({"shear_damping": 1}, 11.8)),
        *(({"shear_damping": 100}, 22.4), ({"stiffness": 5000}, 21.8)),
        *(({"corrector_order": 4}, 9.4), ({"corrector_order": 3}, 6.0), ({"corrections": 2}, 4.51)),
        *(({"integrator": "verlet"}, 1.0), ({"steps_per_cycle": 4000}, 7.6)),
        ({"damping": 500, "shear_damping": 500}, 124.2),
    ],
)
def test_a_time_step_beyond_the_corrector_has_a_caveat(readings, lowest):
    """The frequencies (Hz) are those of docs/physics.md, which rest on real beds."""
    assert not BeltParameters(frequency=1.01 * lowest, **readings).caveat
    if lowest > 1:
        assert "beyond the stability" in BeltParameters(frequency=0.98 * lowest, **readings).caveat


def test_values_in_si_are_multiples_of_what_the_parameter_says():
    point = parse_point({"system": "belt", "damping": 50, "frequency": 20}, "point")
    quantities = in_si(point)
    assert quantities["damping"] == (500, "s-1")
    assert quantities["stiffness"] == (pytest.approx(10), "N m-1")
    assert quantities["average"] == (45 / 20, "s") and quantities["frequency"] == (20, "Hz")
    assert not {"prior_cycles", "overlap_limit", "beads", "seed"} & set(quantities)
    chute = in_si(parse_point({"system": "chute", "cell": 5}, "point"))
    assert chute["cell"] == (pytest.approx(5e-3), "m") and chute["angle"].unit == "degree"
    assert chute["stiffness"] == (100, "N m-1")


def test_no_two_parameters_of_a_system_are_written_alike():
    # One without a symbol goes by its name.
    assert setting("belt", "corrector_order", 2) == "corrector_order = 2"
    assert setting("belt", "prior_cycles", 2) == "t_0 = 2 cycles"
    for system, model in SYSTEMS.items():
        texts = {setting(system, name, 2) for name in model.model_fields}
        assert len(texts) == len(model.model_fields)


RESTITUTIONS = [0.99, 0.8, 0.5, 0.2, np.exp(-2.0), 0.1, 0.01]


def rebound(ratio: float, attraction: str, power: float) -> tuple[float, float]:
    """Return restitution and duration of x'' = -x^power - c x^((power - 1)/2) x' in its own units.

    ``power`` is 1 of a linear spring, 3/2 of Hertz's; c is 2 ζ and √5 ζ. The force acts until it is
    zero, or until the overlap is.
    """
    damping = (2.0 if power == 1 else np.sqrt(5.0)) * ratio

    def force(x, v):
        depth = max(x, 0.0)
        return depth**power + damping * depth ** ((power - 1) / 2) * v

    def ends(_, y):
        return force(*y) if attraction == "clipped" else y[0]

    ends.terminal, ends.direction = True, -1
    options = {"method": "LSODA", "events": ends, "rtol": 1e-10, "atol": 1e-13}
    found = solve_ivp(lambda _, y: [y[1], -force(*y)], (0, 1e3), [1e-9, 1.0], **options)
    return -found.y[1, -1], found.t[-1]


@pytest.mark.parametrize("attraction", ["kept", "clipped"])
@pytest.mark.parametrize("power", [1, 1.5])
@pytest.mark.parametrize("restitution", RESTITUTIONS)
def test_damping_gives_the_restitution_asked_for(restitution, power, attraction):
    share, whole = damping_fraction(restitution, attraction)
    found, time = rebound(share / whole, attraction, power)
    assert found == pytest.approx(restitution, rel=1e-5)
    assert restitution_of(share / whole, attraction) == pytest.approx(restitution, rel=1e-12)
    if power == 1:
        for said in (contact_time(restitution, attraction), time_of(share / whole, attraction)):
            assert time == pytest.approx(np.pi * said, rel=1e-5)


def test_without_loss_there_is_no_damping_and_clipping_takes_more():
    names = "kept", "clipped"
    for name in names:
        assert damping_fraction(1.0, name)[0] == 0.0 and contact_time(1.0, name) == 1.0
    for restitution in RESTITUTIONS:
        kept, clipped = (np.divide(*damping_fraction(restitution, name)) for name in names)
        assert clipped > kept > 0.0
