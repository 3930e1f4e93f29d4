"""What holds for every contact law: a law is tested by being registered.

Those of ``TALUS_PLUGINS`` are tested too.
"""

from functools import cache

import numpy as np
import pytest

from sim.base.additions import shipped
from sim.base.errors import InputError
from sim.claims.experiments import contact_path
from sim.engine.contact import Partners, law_of
from sim.engine.contact.friction import memory_size, turning_numbers
from sim.engine.contact.functions import PartnerLaw
from sim.engine.replicate import Replicate
from sim.engine.states import pack, unpack
from sim.engine.systems import build, leap_frog
from sim.parameters import Parameters, parse_point
from sim.parameters.dashpot import damping_fraction, damping_ratio, restitution_of
from sim.parameters.laws import LAW
from tests.conformance import names_of
from tests.engine_motion.helpers import LAWS, rotation
from tests.engine_motion.motion import Impacts, SphereMotion
from tests.engine_motion.points import energy_residual, series_of

#: Laws with what else their points say: options, and readings that change Walton and Braun's.
CASES = {name: {} for name in names_of(LAW)}
CASES |= {f"{name} clipped": {"attraction": "clipped"} for name in ("spring_dashpot", "drag")}
CASES["spring_dashpot of several sizes"] = {"diameter_spread": 0.3}
CASES["spring_dashpot damped"] = DAMPED = {"normal_damping": 900, "tangential_damping": 500}
CASES["spring_dashpot damped clipped"] = DAMPED | {"attraction": "clipped"}
CASES["hertz rescaled"] = {"attraction": "clipped", "tangential_unloading": "rescaled"}
CASES |= {f"walton_braun {one['overlap_memory']}": one for one in LAWS[1:]}

#: What laws lack by their nature.
LACKING = {
    ("drag", "limit"): "the shear drag has none",
    ("drag clipped", "limit"): "the shear drag has none",
    ("hertz", "cycle"): "keeps the tangential force while its spring softens, unless rescaled",
    ("hertz_mindlin", "cycle"): "as hertz",
    ("walton_braun", "rest"): "loses nothing below the largest overlap: a free oscillator",
    ("walton_braun shrink", "rest"): "as with separation",
    ("walton_braun reset", "rest"): "as with separation, about another force",
    ("walton_braun", "stick"): "its block slides while the force on the plane is low",
    ("walton_braun shrink", "stick"): "as with separation",
    ("walton_braun reset", "stick"): "as with separation",
    ("drag", "stick"): "has no limit",
    ("drag clipped", "stick"): "has no limit",
    ("walton_braun reset", "restitution"): "forgets the dent, and so pushes twice",
    ("walton_braun reset", "energy"): "the second push is for nothing",
}

#: The loops of each type of law take long to compile. "hertz rescaled" and "spring_dashpot damped
#: clipped" are clipped, too, and tests of the reference have the plain "spring_dashpot".
LONG = {"drag clipped", "spring_dashpot", "spring_dashpot clipped"}

FRICTION = 0.3

#: Radii, in diameters, of both spheres, or of the one that meets the plane.
PARTNERS = {"plane": (0.5,), "equal": (0.5, 0.5), "unlike": (0.3, 0.8)}

#: A small flow.
FLOW = {"depth": 4, "cell": 4, "transient": 5, "average": 25}


#: What follows from the restitution, which a law may ignore.
DAMPED_PROPERTIES = {"restitution", "rest"}


def with_property(name: str = ""):
    """Give a test every case but those that lack a property."""
    cases = [
        pytest.param(case, marks=pytest.mark.long) if case in LONG else case
        for case in CASES
        if (case, name) not in LACKING
        and not (name in DAMPED_PROPERTIES and ignores_restitution(case))
    ]
    return pytest.mark.parametrize("case", cases)


def ignores_restitution(case: str) -> bool:
    """Return whether a law has another damping than that of the restitution, or none."""
    point = parse_point({"system": "chute", "law": case.split()[0]}, "test")
    return "restitution" in point.option("law").ignores


with_partners = pytest.mark.parametrize("partners", PARTNERS)


def point_of(case: str, **values) -> Parameters:
    """Return a point of a case, whose time steps are short."""
    given = {"system": "chute", "law": case.split()[0], "steps_per_collision": 400}
    return parse_point(given | CASES[case] | values, "test")


def inelastic(case: str, restitution: float, **values) -> Parameters:
    """Return a point of a case whose equal spheres have a restitution."""
    if "normal_damping" not in CASES[case] or restitution == 1:
        none = {"normal_damping": 0} if restitution == 1 and "normal_damping" in CASES[case] else {}
        return point_of(case, restitution=restitution, **none, **values)
    point = point_of(case)
    share, whole = damping_fraction(restitution, point.attraction)
    rate = 2 * share / whole * (2 * point.stiffness / point.mass) ** 0.5
    return point_of(case, normal_damping=rate, **values)


def impacts(point: Parameters, partners: str, speeds, friction=FRICTION, **motion) -> Impacts:
    """Return impacts of partners under the law of a point; skip those of masses it cannot bear."""
    if partners == "unlike" and point.option("law").one_mass:
        pytest.skip("for equal masses alone")
    radii = point.diameter * np.array(PARTNERS[partners])
    mass = point.mass * (2 * radii / point.diameter) ** 3
    law = law_of(point, Partners(friction, 1 / sum(1 / mass), point.time_step))
    return Impacts(law, radii, mass, point.time_step, speeds, **motion)


def velocity_units(point: Parameters, *speeds: float) -> np.ndarray:
    """Return speeds in m/s of those in the unit of a point."""
    return point.velocity_unit * np.array(speeds)


@with_partners
@with_property("restitution")
def test_the_restitution_is_that_of_the_point_at_every_speed(case, partners):
    for restitution in (0.5, 1.0):
        point = inelastic(case, restitution)
        speeds = velocity_units(point, 0.02, 0.2, 1, 5)
        made = impacts(point, partners, speeds)
        if point.normal_damping:
            mass = 1 / sum(1 / made.mass)
            ratio = damping_ratio(point.normal_damping, point.stiffness, mass)
            restitution = restitution_of(ratio, point.attraction)
        parting = made.run_until_parted().velocities()[:, 0]
        assert parting / speeds == pytest.approx(restitution, abs=0.01)


@with_property()
def test_the_time_of_the_shortest_collision_is_what_the_law_says(case):
    for spread in (0.0,) if point_of(case).option("law").one_mass else (0.0, 0.3):
        point = point_of(case, diameter_spread=spread, steps_per_collision=200)
        radii, mass = np.full(2, 0.5 * point.diameter * (1 - spread)), point.lightest_mass
        law = law_of(point, Partners(FRICTION, 0.5 * mass, point.time_step))
        made = Impacts(law, radii, [mass, mass], point.time_step, velocity_units(point, 0.1, 10))
        pushes = np.array([made.motion.run(4).force.reshape(2, -1).any(axis=1) for _ in range(250)])
        assert not pushes[-1].any()
        assert min(pushes.sum(axis=0) / 50) == pytest.approx(1, rel=0.12)


@with_partners
@with_property()
def test_surfaces_that_roll_on_each_other_feel_no_friction(case, partners):
    """Spheres like gears; a sphere on the plane like a wheel."""
    point = inelastic(case, 0.5)
    speeds, rolling = velocity_units(point, 0.2), velocity_units(point, 0.4)
    radii = point.diameter * np.array(PARTNERS[partners])
    signs = np.array([1.0, -1.0])[: len(radii)]
    turning = (rolling * signs / radii)[:, None] * [0, 0, 1]
    slides = rolling if partners == "plane" else 0.0
    made = impacts(point, partners, speeds, slides=slides, spins=turning).run_until_parted()
    _, along, *rims = made.velocities()[0]
    assert rims == pytest.approx(rolling * signs, rel=1e-11)
    assert along == pytest.approx(slides, rel=1e-11, abs=1e-12 * rolling[0])


@with_partners
@with_property("limit")
def test_gross_sliding_takes_what_the_friction_of_the_impact_gives(case, partners):
    """3.5 (1 + e) μ v_n of the slip; so slow that pairs hardly turn while they touch."""
    speeds = velocity_units(point := point_of(case), 0.01, 0.02)
    made = impacts(point, partners, speeds, slides=10 * speeds).run_until_parted()
    lost, parting = 10 * speeds - made.slips(), made.velocities()[:, 0]
    assert lost == pytest.approx(3.5 * FRICTION * (speeds + parting), rel=0.02)


@with_partners
@with_property()
def test_without_friction_surfaces_slide_as_before(case, partners):
    values = {"shear_damping": 0} if case.startswith("drag") else {}
    speeds = velocity_units(point := point_of(case, **values), 0.2)
    made = impacts(point, partners, speeds, friction=0.0, slides=speeds).run_until_parted()
    _, along, *rims = made.velocities()[0]
    if partners == "plane":
        assert along == pytest.approx(speeds[0], rel=1e-12)
    assert not np.any(rims)


def oblique(case: str, partners: str, number: int = 30) -> Impacts:
    """Return random impacts of spheres that slide and spin."""
    rng, point = np.random.default_rng(11), point_of(case)
    slides = velocity_units(point, *rng.uniform(-0.6, 0.6, number))
    spins = 40 * rng.normal(size=(number, len(PARTNERS[partners]), 3))
    speeds = np.full(number, 0.2 * point.velocity_unit)
    return impacts(point, partners, speeds, slides=slides, spins=spins)


@with_partners
@with_property("energy")
def test_every_impact_loses_energy_as_the_law_says(case, partners):
    made = oblique(case, partners)
    motion, sums = made.motion, made.motion.flow.sums

    def energies() -> np.ndarray:
        spheres = motion.mass * (motion.velocity**2).sum(axis=1)
        spheres += motion.moment_of_inertia * (motion.spin**2).sum(axis=1)
        return 0.5 * spheres.reshape(made.number, -1).sum(axis=1)

    before = energies()
    made.run_until_parted()
    lost, said = before - energies(), sums[[leap_frog.NORMAL_LOSS, leap_frog.FRICTION_WORK]]
    assert (lost > 0).all() and said[1] > 0 and (said[0] > 0 or ignores_restitution(case))
    assert lost.sum() == pytest.approx(said.sum(), rel=0.02)


@cache
def flow(case: str) -> dict[str, np.ndarray]:
    """Return the time series of a small flow."""
    return series_of(point_of(case, **FLOW, steps_per_collision=40))


@with_property("energy")
def test_the_energy_of_a_flow_adds_up(case):
    point = point_of(case, **FLOW, steps_per_collision=40)
    # Of first order in the step: drag that is clipped leaves 1.1, 0.6 and 0.3 % at t_c/40, 80, 160.
    assert abs(energy_residual(flow(case), build(point, 0).ledger)) < 1.2e-2


@with_property()
def test_flows_have_the_same_bits_twice_and_after_a_pause(case):
    point = point_of(case, **FLOW, steps_per_collision=40)
    replicate = Replicate(point, 0)
    system = replicate.system
    option = system.parameters.option("law")
    numbers = 3 + 7 * option.rolls + option.of(type(system.laws[0]))[1]
    assert system.memory.shape[:2] == system.plane.memory.shape[:2] == (2, numbers)
    assert {memory_size(type(law)) for law in system.laws} == {numbers}
    for number in range(6):
        outcome = system.sample()
        sample = outcome.first()
        assert all(sample[name] == flow(case)[name][number] for name in system.series)
        if number == 2:
            replicate.recorder.take_snapshot()
            replicate.recorder.take(outcome)
            system = Replicate.from_state(point, 0, unpack(pack(replicate.state()))).system


@pytest.mark.parametrize("partners", ["equal", "unlike"])
@with_property()
def test_forces_are_opposite_and_torques_those_of_one_force(case, partners):
    made = oblique(case, partners, number=1)
    motion, touched = made.motion, 0
    for _ in range(200):
        motion.run(2)
        scale = np.abs(motion.force).max()
        assert np.abs(motion.force.sum(axis=0)).max() <= 1e-12 * scale
        first, second = motion.torque / made.radii[:, None]
        assert np.abs(first - second).max() <= 1e-12 * scale
        # A little late the normal has turned by what the pair has turned in a step.
        assert abs(first @ made.axes[0]) <= 0.05 * scale
        touched += bool(scale) and np.abs(first).max() > 0
    assert touched > 50
    assert np.abs(motion.momentum()).max() < 1e-12 * motion.mass.max() * np.linalg.norm(made.start)


@with_property()
def test_any_history_is_that_of_the_turned_and_the_swapped_partners(case):
    """And its friction is tangential, and within the limit of those laws that have one."""
    point = point_of(case)
    law = law_of(point, Partners(FRICTION, 0.5 * point.mass, point.time_step))
    turning = turning_numbers(law)
    if point.option("law").has_functions(type(law)):
        law = PartnerLaw(law, 0.25 * point.diameter, 0.5 * point.mass)
    rng = np.random.default_rng(7)
    normal = [0, 0, 1] + 0.1 * rng.normal(size=(3000, 3)).cumsum(axis=0) / 30
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    slip = 1e-7 * rng.normal(size=(3000, 3)).cumsum(axis=0) / 30
    slip -= (slip * normal).sum(axis=1)[:, None] * normal
    overlap = 1e-5 * (1 + 0.9 * np.sin(rng.normal(0, 0.1, 3000).cumsum()))
    force, friction, memory = contact_path(law, overlap, normal, slip)
    size, limit = np.linalg.norm(friction, axis=1), FRICTION * np.abs(force)
    assert np.abs((friction * normal).sum(axis=1)).max() < 1e-12 * size.max()
    if (case, "limit") not in LACKING:
        assert (size <= limit * (1 + 1e-12)).all()
        assert 0.05 < np.mean(size < 0.97 * limit) < 0.95
    swapped = contact_path(law, overlap, -normal, -slip)
    assert np.array_equal(swapped[0], force) and np.array_equal(swapped[1], -friction)
    assert np.array_equal(swapped[2][:, :turning], -memory[:, :turning])
    assert np.array_equal(swapped[2][:, turning:], memory[:, turning:])
    frame = rotation(rng)
    turned = contact_path(law, overlap, normal @ frame.T, slip @ frame.T)
    assert turned[0] == pytest.approx(force, rel=1e-12)
    assert np.abs(turned[1] - friction @ frame.T).max() < 1e-9 * limit.max()


@with_partners
@with_property()
def test_a_contact_that_ends_is_forgotten(case, partners):
    made = oblique(case, partners)
    spheres, number = made.motion.spheres, len(made.motion.mass)
    start = {name: getattr(spheres, name).copy() for name in ("position", "velocity", "rim")}
    labels = spheres.label[0].copy()
    found = []
    for _ in range(2):
        made.run_until_parted()
        found.append(made.velocities())
        back = np.argsort(labels)[spheres.label[0]]
        for name, columns in start.items():
            getattr(spheres, name)[:, :number] = columns[:, back]
    assert found[1] == pytest.approx(found[0], abs=1e-9 * np.abs(found[0]).max())


@with_property()
def test_points_beyond_the_masses_and_overlaps_of_a_law_are_refused_or_have_a_caveat(case):
    law = point_of(case).option("law")
    for name in ("bumps", "diameter_spread"):
        if law.one_mass:
            with pytest.raises(InputError, match=rf"{name}: got 0.1; allowed: 0 with law"):
                point_of(case, **{name: 0.1})
        else:
            point_of(case, **{name: 0.1})
    if np.isfinite(law.max_overlap):
        point = point_of(case)
        speed = law.max_overlap * point.diameter * (2 * point.stiffness / point.mass) ** 0.5
        for share in (0.98, 1.02):
            start = 2 * share * speed / point.velocity_unit
            has_caveat = "overlap" in point_of(case, initial_velocity=start).caveat
            assert has_caveat == (share > 1)


def test_laws_that_ship_and_the_table_of_what_is_lacking_are_those_that_points_may_name():
    lacking = {case for case, _ in LACKING} - {"hertz_mindlin"}
    assert set(shipped("law")) == set(LAW.usual) and lacking <= CASES.keys()


# What holds for every contact law that presses on: closed cycles, rest, and a block that sticks.
#
# `test_laws` has the cases and what laws lack.


def closed_cycles(rng, steps: int = 1000, rounds: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Return overlaps (n,) and slips (n, 3) in m of a contact that begins, goes round and ends."""
    time, mode = np.linspace(0, rounds, rounds * steps + 1)[:, None], np.arange(1, 4)
    sines, cosines = rng.normal(size=(2, 3, 3)) / mode[:, None]
    angle = 2 * np.pi * time * mode
    curves = np.sin(angle) @ sines + (np.cos(angle) - 1) @ cosines
    curves /= np.abs(curves).max(axis=0)
    loading = np.linspace(0, 1, 200)
    overlap = 1e-5 * (1 + 0.8 * curves[:, 0])
    path = np.concatenate([loading[:-1] * overlap[0], overlap, loading[-2::-1] * overlap[-1]])
    slip = np.zeros((path.size, 3))
    slip[200 : 200 + rounds * steps, :2] = 1e-6 * np.diff(curves[:, 1:], axis=0)
    return path, slip


@pytest.mark.parametrize("friction", [FRICTION, 50.0])
@with_property("cycle")
def test_no_closed_cycle_of_load_and_shear_gives_energy(case, friction):
    """Friction alone gives none, whether it sticks all the time (50) or slides now and then."""
    point = point_of(case)
    law = law_of(point, Partners(friction, 0.5 * point.mass, point.time_step))
    if point.option("law").has_functions(type(law)):
        law = PartnerLaw(law, 0.25 * point.diameter, 0.5 * point.mass)
    rng = np.random.default_rng(3)
    for _ in range(20):
        overlap, slip = closed_cycles(rng)
        normal = np.tile([0.0, 0.0, 1.0], (overlap.size, 1))
        force, along, _ = contact_path(law, overlap, normal, slip)
        means = [0.5 * (one + np.roll(one, 1, axis=0)) for one in (force, along)]
        rubbing = (means[1] * slip).sum(axis=1)
        pressing = means[0] * np.diff(overlap, prepend=0.0)
        assert rubbing.sum() >= -1e-3 * np.abs(rubbing).sum()
        assert rubbing.sum() + pressing.sum() >= 0


def placed(case: str, slope: float, **options) -> SphereMotion:
    """Return a sphere that begins to press the plane, where gravity has a slope of ``slope``."""
    point = inelastic(case, 0.5, steps_per_collision=40)
    law = law_of(point, Partners(FRICTION, point.mass, point.time_step))
    radius, weight = 0.5 * point.diameter, point.gravity / np.hypot(1, slope)
    return SphereMotion(
        [[0.0, 0.0, radius]],
        np.zeros((1, 3)),
        law=law,
        time_step=point.time_step,
        radius=radius,
        mass=point.mass,
        gravity=(float(slope * weight), 0.0, -float(weight)),
        **options,
    )


@with_property("rest")
def test_a_sphere_on_the_plane_comes_to_rest_with_its_weight_on_it(case):
    one = placed(case, 0.0).run(6000)
    weight = one.mass[0] * -one.drive.gravity[2]
    for _ in range(50):
        assert one.run(7).force[0, 2] == pytest.approx(weight, rel=1e-6)


@pytest.mark.parametrize("share", [0.98, 1.02])
@with_property("stick")
def test_a_block_sticks_below_the_friction_limit_and_slides_above_it(case, share):
    slope, steps = share * FRICTION, 6000
    one = placed(case, slope, inertia=np.inf).run(6000)
    start, speed = one.position[0, 0], one.velocity[0, 0]
    one.run(steps)
    time = steps * one.time_step
    excess = one.drive.gravity[0] + FRICTION * one.drive.gravity[2]
    way = one.position[0, 0] - start
    if share > 1:
        assert way == pytest.approx(speed * time + 0.5 * excess * time**2, rel=1e-3)
    else:
        # Its spring swings, as nothing damps it, about one place.
        assert abs(way) < 1e-2 * abs(0.5 * excess) * time**2
