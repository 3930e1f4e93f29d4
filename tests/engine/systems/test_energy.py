"""The energy ledger of whole flows: what goes in, what is stored and what is lost add up."""

import numpy as np
import pytest

from sim.engine.systems.belt import Belt
from sim.engine.systems.chute import Chute
from tests.engine_motion.helpers import LAWS
from tests.engine_motion.points import belt_point, chute_point, energy_residual, series_of

CHUTE = {"depth": 4, "cell": 4, "transient": 5, "average": 25}
BELT = {"beads": 60, "width": 8, "transient": 2, "average": 8}


def residual(point, system) -> float:
    """What the ledger lacks after the first sample, relative to the energy turned over."""
    return energy_residual(series_of(point), system.ledger)


@pytest.mark.parametrize(
    ("values", "allowed"),
    [
        ({}, 1e-3),
        (LAWS[1], 1e-3),
        ({**LAWS[1], "restitution": 1.0}, 2e-3),
        ({"friction": 0.0}, 1e-3),
        ({"law": "hertz", "diameter_spread": 0.3}, 5e-3),
        ({"law": "drag", "bumps": 0.5}, 1e-2),
    ],
)
def test_the_chute_loses_what_it_gains(values, allowed):
    assert abs(residual(chute_point(**CHUTE, **values), Chute)) < allowed


def test_forgetting_the_dent_makes_energy():
    """The reading `reset` pushes spheres apart once more for nothing: the ledger shows it."""
    assert residual(chute_point(**CHUTE, **LAWS[2]), Chute) > 0.01


def test_the_ledger_converges_with_the_time_step():
    coarse, fine = (
        abs(residual(chute_point(**CHUTE, steps_per_collision=steps), Chute)) for steps in (12, 80)
    )
    assert fine < 0.3 * coarse


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"frequency": 60},
        {"damping_mass": "reduced", "attraction": "clipped", "integrator": "verlet"},
        {"belt_ghost": "centred"},
        {"obstacle": 1.5},
        {"shear_damping": 0},
        {"integrator": "verlet"},
    ],
)
def test_the_belt_does_the_work_that_damping_takes(values):
    assert abs(residual(belt_point(**BELT | values), Belt)) < 5e-3


def test_elastic_spheres_without_friction_lose_nothing():
    point = chute_point(**CHUTE, restitution=1.0, friction=0.0)
    series = series_of(point)
    assert series["normal_loss"][-1] == 0.0
    assert np.abs(series["frictional_loss"]).max() == 0.0


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
