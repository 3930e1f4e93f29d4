"""When a run of the converged protocol ends, and how often it is right."""

import numpy as np
import pytest

from sim.engine.observe import regime as stopping
from sim.engine.observe.regime import Scales
from tests.engine_motion.series import correlated, with_transient


def scales(target: float = 0.02) -> Scales:
    return Scales(arrested=1e-3, acceleration=np.inf, drift=0.1, target=target)


def run_to_the_end(velocity, shortest, target=0.02):
    """Look at a series as a run would; return length, window start, trend and reason."""
    before = ""
    for length in stopping.look_lengths(shortest, len(velocity)):
        start, trend, reason = stopping.verdict(velocity[:length], 1.0, scales(target), 1, 0)
        if reason and reason in (before, stopping.ARRESTED):
            return length, start, trend, reason
        before = reason
    return length, start, trend, ""


def test_looks_are_few_and_end_at_the_limit():
    assert stopping.look_lengths(100, 500) == [100, 135, 182, 246, 332, 448, 500]
    assert stopping.look_lengths(100, 100) == [100]


def test_a_run_stops_when_its_mean_is_known_well_enough():
    """Of 60 noisy runs all stop at the target, before the limit, and nineteen in twenty cover."""
    rng = np.random.default_rng(5)
    covered, lengths = [], []
    for _ in range(60):
        velocity = 5.0 + with_transient(rng, 40_000, 10, 5.0, 0.004)
        length, _, trend, reason = run_to_the_end(velocity, 400)
        assert reason == stopping.TARGET
        assert trend.velocity.half_width <= 0.02 * trend.velocity.value
        lengths.append(length)
        covered.append(abs(trend.velocity.value - 5.0) < trend.velocity.half_width)
    assert np.mean(covered) > 0.88
    assert max(lengths) < 40_000


@pytest.mark.parametrize("relaxation", [300, 600])
def test_a_slow_relaxation_is_waited_for(relaxation):
    """A flow that still relaxes when it is first looked at ends with the steady mean.

    Of 40 runs those that stop at the target are off by less than the target on average, and 17 in
    20 of their intervals hold; the others go on to the limit.
    """
    rng = np.random.default_rng(14)
    time = np.arange(12_000)
    off, held = [], []
    for _ in range(40):
        velocity = 1.0 - 0.3 * np.exp(-time / relaxation) + 0.02 * correlated(rng, time.size, 20)
        _, _, trend, reason = run_to_the_end(velocity, 2000)
        assert reason == stopping.TARGET
        off.append(trend.velocity.value - 1.0)
        held.append(abs(off[-1]) < trend.velocity.half_width)
    assert abs(np.mean(off)) < 0.01
    assert np.mean(held) > 0.8


def test_a_stricter_target_takes_longer():
    velocity = 5.0 + correlated(np.random.default_rng(6), 50_000, 10)
    loose, strict = (run_to_the_end(velocity, 400, target)[0] for target in (0.04, 0.01))
    assert strict > 3 * loose


def test_a_noisy_run_goes_on_to_its_limit():
    velocity = 1.0 + correlated(np.random.default_rng(7), 2000, 50)
    assert run_to_the_end(velocity, 400)[::3] == (2000, "")


def test_a_flow_at_rest_is_not_waited_for():
    velocity = np.concatenate([np.linspace(5.0, 0.0, 100), np.zeros(3000)])
    length, _, trend, reason = run_to_the_end(velocity, 400)
    assert (length, trend.regime, reason) == (400, "arrested", stopping.ARRESTED)


def test_an_acceleration_that_lasts_is_not_waited_for():
    velocity = 0.01 * np.arange(5000) + 0.1 * correlated(np.random.default_rng(8), 5000, 5)
    length, _, trend, reason = run_to_the_end(velocity, 400)
    assert (trend.regime, reason) == ("accelerating", stopping.ACCELERATING)
    assert length < 1000


def test_the_rise_of_a_transient_is_not_taken_for_a_lasting_acceleration():
    rng = np.random.default_rng(9)
    for _ in range(20):
        time = np.arange(6000)
        velocity = 20.0 * (1 - np.exp(-time / 500)) + 0.3 * correlated(rng, 6000, 10)
        _, start, trend, reason = run_to_the_end(velocity, 500)
        assert reason == stopping.TARGET
        assert trend.velocity.value == pytest.approx(20.0, rel=0.03)
        assert start > 500


def test_the_window_of_a_driven_series_starts_with_a_cycle():
    wave = np.sin(2 * np.pi * np.arange(1010) / 20)
    start = stopping.window_start(wave + np.exp(-np.arange(1010) / 50), 20)
    assert (1010 - start) % 20 == 0 and start > 0


@pytest.mark.parametrize("least", [0, 7, 100, 333])
def test_what_is_known_to_be_transient_is_left_out_in_any_case(least):
    noise = correlated(np.random.default_rng(10), 1000, 3)
    start = stopping.window_start(noise, 20, least)
    assert start >= least and (1000 - start) % 20 == 0
