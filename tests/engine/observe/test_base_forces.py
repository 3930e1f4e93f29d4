"""Base forces of a window: means, errors of bounded fluctuations, momentum budget."""

import numpy as np
import pytest

from sim.engine.observe.force_balance import BLOCKS, base_forces, bounded_error, momentum_budget

INTERVAL, MASS, WEIGHT = 0.01, 2.0, 3.0


def flow(samples: int, seed: int):
    """Velocity that wanders, and the base force that Newton's law then asks for."""
    velocity = np.cumsum(np.random.default_rng(seed).normal(size=samples + 1)) * 0.01
    # The means of two neighboring intervals differ by the force over a ramp up and down.
    fine = np.repeat(np.diff(velocity) / INTERVAL, 2)
    force = WEIGHT - MASS * fine
    mean = 0.5 * (velocity[1:] + velocity[:-1])
    return force.reshape(-1, 2).mean(axis=1), mean


def test_the_budget_is_the_weight_along_the_slope_within_its_error():
    for seed in range(20):
        shear, velocity = flow(400, seed)
        budget, error = momentum_budget(shear, MASS * velocity, INTERVAL)
        assert abs(budget - WEIGHT) < 5 * error


def test_the_error_of_a_bounded_fluctuation_falls_with_the_length():
    wave = np.sin(np.arange(6000) * 0.37)
    assert bounded_error(wave) < 0.15 * bounded_error(wave[:600])
    blocks = [np.std([part.mean() for part in np.array_split(wave, b)], ddof=1) / b for b in BLOCKS]
    assert bounded_error(wave) == pytest.approx(max(blocks), rel=1e-12)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("samples", [0, 1])
def test_a_window_of_one_sample_has_no_error(samples):
    found = base_forces(*(np.ones(samples) for _ in range(3)), MASS, (0.5, 2.0), INTERVAL)
    assert np.isnan(found["base_normal_error"]) and np.isnan(found["momentum_budget"])
    assert found["base_normal"] == 1.0 or samples == 0


def test_balances_are_relative_to_the_weight():
    found = base_forces(np.full(20, 0.6), np.full(20, 1.9), np.ones(20), MASS, (0.5, 2.0), INTERVAL)
    assert found["shear_balance"] == pytest.approx(1.2)
    assert found["normal_balance"] == pytest.approx(0.95)


def test_a_level_plane_carries_no_weight_along_it():
    found = base_forces(np.zeros(20), np.ones(20), np.zeros(20), MASS, (0.0, 1.0), INTERVAL)
    assert np.isnan(found["shear_balance"])
