"""Short flows: force balance, regimes by depth, time step, friction below tan, energy ledger."""

import numpy as np
import pytest

from sim.engine.observe.regime import analyse, batch_means
from sim.engine.observe.samples import add_sums
from sim.engine.systems import build
from sim.engine.systems.belt import Belt
from sim.engine.systems.chute import Chute
from sim.parameters.belt import SETTLING_TIME
from sim.parameters.variables import AT_PHASE_0, parts
from tests.engine_motion.points import belt_point, chute_point, energy_residual, series_of, sums_of

SYSTEMS = {"chute": Chute, "belt": Belt}
SIN, TAN = np.sin(np.radians(17)), np.tan(np.radians(17))


def trend_of(p, replicate=0):
    """Series of a replicate within the averaging window, and the trend of its mean velocity."""
    series = {name: v[p.transient_samples :] for name, v in series_of(p, replicate).items()}
    interval = p.sample_steps * p.time_step
    return series, analyse(series["mean_velocity"], interval, build(p, replicate).scales)


def test_half_a_layer_accelerates_as_spheres_that_roll_alone():
    p = chute_point(depth=0.5, cell=8, transient=50, average=100)
    series, trend = trend_of(p)
    assert trend.regime == "accelerating"
    assert trend.acceleration.value == pytest.approx(5 / 7 * p.gravity * SIN, rel=0.02)
    assert series["mean_velocity"][-1] > 30 * p.velocity_unit


@pytest.mark.parametrize(
    ("changes", "velocity"),
    [
        ({"depth": 1.24}, 4.5),
        pytest.param({"depth": 2.5}, 4.5, marks=pytest.mark.long),
        pytest.param({"depth": 1.24, "sliding_direction": "slip"}, 4.5, marks=pytest.mark.long),
        pytest.param({"depth": 1.24, "law": "spring_dashpot"}, 4.5, marks=pytest.mark.long),
        pytest.param({"depth": 1.24, "law": "hertz"}, 4.5, marks=pytest.mark.long),
        ({"depth": 1.24, "law": "drag"}, 0.12),
    ],
)
def test_shallow_flows_become_steady_in_balance_with_gravity(changes, velocity):
    """Steady within 2 % of g sin(17): a velocity that changes by less than its own fluctuations.

    The base forces then balance the weight but for the momentum that the flow still changes.
    """
    p = chute_point(**changes, cell=6, transient=150, average=250)
    series, trend = trend_of(p)
    assert abs(trend.acceleration.value) < 0.02 * p.gravity * SIN
    assert trend.velocity.value / p.velocity_unit == pytest.approx(velocity, rel=0.3)
    weight = p.particles * p.mass * p.gravity
    shear, normal = series["base_shear_force"].mean(), series["base_normal_force"].mean()
    assert shear / weight == pytest.approx(SIN, rel=0.02)
    assert normal / weight == pytest.approx(np.cos(np.radians(17)), rel=2e-3)
    blocks = batch_means(series["base_shear_force"], 20) / normal
    assert shear / normal == pytest.approx(TAN, abs=2 * blocks.std(ddof=1) / np.sqrt(20))
    assert shear / normal == pytest.approx(TAN, rel=0.02)


def test_steady_velocity_does_not_depend_on_the_time_step():
    """Between t_c/20 and t_c/80, within the 2 % that one such run is uncertain by, thrice."""
    found = []
    for steps in (20, 80):
        p = chute_point(depth=1.24, cell=6, transient=80, average=150, steps_per_collision=steps)
        found.append(trend_of(p)[1].velocity.value / p.velocity_unit)
    assert np.ptp(found) < 0.1 * np.mean(found)


@pytest.mark.parametrize("depth", [1.24, 5])
def test_friction_below_the_tangent_lets_every_depth_accelerate(depth):
    friction = 0.2
    p = chute_point(depth=depth, cell=4, friction=friction, transient=20, average=30)
    _, trend = trend_of(p)
    bound = p.gravity * (SIN - friction * np.cos(np.radians(17)))
    assert trend.acceleration.value > 0.95 * bound
    assert trend.regime == "accelerating"


def residual(point) -> float:
    """What the ledger lacks after the first sample, relative to the energy turned over."""
    return abs(energy_residual(series_of(point), SYSTEMS[point.system].ledger))


def test_the_ledger_of_a_chute_converges_with_the_time_step():
    given = {"depth": 4, "cell": 4, "transient": 5, "average": 25}
    coarse, fine = (residual(chute_point(**given, steps_per_collision=n)) for n in (12, 80))
    assert fine < 0.3 * coarse
    elastic = series_of(chute_point(**given, restitution=1.0, friction=0.0))
    assert elastic["normal_loss"][-1] == np.abs(elastic["frictional_loss"]).max() == 0.0


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"damping_mass": "reduced", "attraction": "clipped", "integrator": "verlet"},
        {"belt_ghost": "centred", "obstacle": 1.5, "frequency": 60},
        {"shear_damping": 0},
        pytest.param({"integrator": "verlet"}, marks=pytest.mark.long),
    ],
)
def test_the_belt_does_the_work_that_damping_takes(values):
    small = {"beads": 60, "width": 8, "transient": 2, "average": 8}
    assert residual(belt_point(**small | values)) < 5e-3


def test_powers_add_up_to_what_gravity_gives():
    """N m g V sin θ in a flow that has forgotten its start, within what it still stores."""
    point = chute_point(depth=1.24, cell=5, transient=100, average=150)
    series = series_of(point)
    start = point.transient_samples
    interval = point.sample_steps * point.time_step
    time = interval * (len(series["normal_loss"]) - 1 - start)
    lost = sum(
        series[name][-1] - series[name][start] for name in ("normal_loss", "frictional_loss")
    )
    weight = point.particles * point.mass * point.gravity * np.sin(np.radians(point.angle))
    assert lost / time == pytest.approx(weight * series["mean_velocity"][start:].mean(), rel=0.02)


SMALL = {"beads": 40, "width": 8}

#: Readings under which forces of pairs are opposite; the loop for them is one that others need.
OPPOSITE = {"damping_mass": "reduced", "attraction": "clipped", "integrator": "verlet"}


def settled_belt(replicate=0, **values):
    system = build(belt_point(**SMALL | values), replicate)
    system.settle()
    return system


@pytest.mark.parametrize("ghost", ["below", "centred"])
def test_settled_bed_rests_on_the_belt(ghost):
    """The belt carries the weight; every bead lies above it, next to none deeply overlapped."""
    system = settled_belt(belt_ghost=ghost)
    p, disks = system.parameters, system.disks
    assert (system._velocity() ** 2).sum(axis=0).mean() < p.settle_velocity_squared
    surface = 0.5 * p.diameter if ghost == "centred" else 0.0
    gap = disks.taylor[0, 1] - disks.radius - surface
    assert gap.min() > -0.1 * p.diameter
    touching = gap < 0
    assert 3 < touching.sum() < 14
    weight = disks.mass.sum() * p.gravity
    belt_force = p.stiffness * p.gravity * p.mass / p.diameter * -gap[touching].sum()
    assert belt_force == pytest.approx(weight, rel=0.1)


def test_shaking_takes_over_the_velocities_of_settling_whatever_its_time_step():
    """Stopped while the beads still move: the end of settling does not know the frequency."""
    beds = [settled_belt(frequency=f, settle_velocity_squared=10.0) for f in (20, 200)]
    slow, fast = (system.snapshot()["particle_velocity"] for system in beds)
    assert fast == pytest.approx(slow, rel=1e-9)
    assert np.abs(slow).max() > 1e-3
    assert beds[1].parameters.time_step < 0.2 * beds[0].parameters.time_step


def test_start_overlaps_neither_belt_nor_obstacle():
    system = build(belt_point(obstacle=2.5, phase=90.0, belt_ghost="centred"), 0)
    place, radius = system.disks.taylor[0].T, system.disks.radius
    p = system.parameters
    assert (place[:, 1] - radius > p.amplitude * p.diameter + 0.5 * p.diameter - 1e-15).all()
    apart = place - [system.obstacle.x, system.obstacle.z]
    assert (np.linalg.norm(apart, axis=1) > radius + system.obstacle.radius - 1e-15).all()
    assert (system.obstacle.x, system.obstacle.z) == pytest.approx((10e-3, p.amplitude * 1e-3))
    assert system.obstacle.radius == pytest.approx(1.25e-3)


@pytest.mark.parametrize(("phase", "begins"), [(0.0, 0), (80.0, 16)])
def test_profiles_of_the_start_of_the_cycle_are_those_of_one_sample_in_twenty(phase, begins):
    """Samples are 18 degrees apart: from 80 on number 16, at 8 degrees, is nearer than 15."""
    system = settled_belt(phase=phase, phase_0_profiles=True, slice_height=0.5)
    total, start_profiles = system.slices.empty(), []
    for number in range(1, 41):
        sums = sums_of(system)
        total = add_sums(total, sums)
        if number % 20 == begins:
            start_profiles.append(system.slices.profiles(sums))
    tables, profiles = system.slices.tables(total), system.slices.profiles(total)
    for phased, name in parts(AT_PHASE_0, "belt").items():
        mean = np.mean([profiles_of_start[name] for profiles_of_start in start_profiles], axis=0)
        if name != "velocity_profile":
            assert tables[phased] == pytest.approx(mean)
        assert not np.array_equal(tables[phased], profiles[name], equal_nan=True)
    assert profiles["number_density"].sum() == pytest.approx(np.sum(mean))


@pytest.mark.parametrize(("damping", "shear_damping"), [(5, 0), (0, 0.8)])
def test_a_bed_of_little_damping_settles_in_about_the_steps_of_its_estimate(damping, shear_damping):
    values = {"beads": 10, "width": 5, "damping": damping, "shear_damping": shear_damping}
    point = belt_point(**values)
    system = build(point, 0)
    counts = []
    system._enter = lambda stage: counts.append(int(system.loop.step[0]))
    system.settle()
    assert point.settling_steps / 5 < counts[0] < 2 * point.settling_steps
    assert counts[0] > SETTLING_TIME / point.settling_step


def test_the_force_on_the_belt_is_what_changes_the_momentum_of_the_bed():
    """Forces of pairs with the reduced mass are opposite, so they leave the momentum as it is."""
    shaken = {"frequency": 25, "steps_per_cycle": 8000}
    p = belt_point(beads=40, width=10, belt_forces=True, **shaken, **OPPOSITE)
    system = build(p, 0)
    system.settle()
    mass, interval = system.disks.mass, p.sample_steps * p.time_step
    weight = mass.sum() * p.gravity
    before, samples = np.zeros(2), []
    for _ in range(60):
        samples.append(system.advance())
        after = system._velocity() @ mass
        shear, normal = samples[-1]["belt_shear_force"], samples[-1]["belt_normal_force"]
        gained = (after - before) / interval
        assert np.array([-shear, normal - weight]) == pytest.approx(gained, abs=0.02 * weight)
        before = after
    forces = [sample["belt_normal_force"] for sample in samples]
    assert 0.0 in forces and max(forces) > 2 * weight
    times = [sample["belt_contact_time"] for sample in samples]
    assert min(times) == 0.0 and max(times) == 1.0
    for sample, touched in zip(samples, times, strict=True):
        assert touched <= sample["belt_contacts"] <= 40 * touched
        assert (sample["belt_normal_force"] == 0.0) == (touched == 0.0)


def test_a_belt_without_shear_damping_moves_nothing_along():
    """With the reduced mass exactly: no force on the bed has a part along the belt."""
    system = settled_belt(shear_damping=0.0, **OPPOSITE)
    speed = 1e-3 * 2 * np.pi * 20
    start = system.disks.mass @ system._velocity()[0]
    for _ in range(100):
        system.advance()
        gained = system.disks.mass @ system._velocity()[0] - start
        assert abs(gained) < 1e-12 * system.disks.mass.sum() * speed


def mean_transport(frequency, beds, **values) -> np.ndarray:
    """Mean velocities of some beds half as long as usual, in the belt's largest A_x 2 pi f."""
    p = belt_point(frequency=frequency, beads=50, width=10, **values)
    speed = p.amplitude * p.diameter * 2 * np.pi * frequency
    runs = (series_of(p, bed)["mean_velocity"] for bed in range(beds))
    return np.array([run[p.transient_samples :].mean() for run in runs]) / speed


def test_no_transport_below_take_off():
    """At 10 Hz Gamma is 0.39. Contacts are resolved: the published step is too long for Gear here.

    Single beds creep by up to four hundredths of A_x w, with the same beds and rates at half the
    step, as drag knows no static friction; no ensemble of beds is carried along.
    """
    found = mean_transport(10, beds=5, transient=6, average=6, steps_per_cycle=4000)
    assert abs(found.mean()) < 0.01
    assert np.abs(found).max() < 0.06


def test_transport_sets_in_between_15_and_17_hz():
    """Flow is V > 0.02 A_x w and > 5 standard errors; at 15 Hz beds creep at 0.03 +- 0.02.

    So the rise is what is tested: hardly any transport at 15 Hz, plenty at 17 Hz.
    """
    below, above = (mean_transport(f, beds=3, transient=15, average=12) for f in (15, 17))
    assert below.mean() < 0.08
    assert above.mean() > 0.2
    assert above.mean() > 5 * above.std(ddof=1) / np.sqrt(3)
    assert above.mean() > 4 * below.mean()
