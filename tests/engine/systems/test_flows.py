"""Short flows: force balance, regimes by depth, time step, friction below tan, energy ledger."""

import numpy as np
import pytest

from sim.engine.observe.regime import analyse, batch_means
from sim.engine.systems import build
from sim.engine.systems.belt import Belt
from sim.engine.systems.chute import Chute
from tests.engine_motion.points import belt_point, chute_point, energy_residual, series_of

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
    for steps in (20, 40, 80):
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
