"""Lifetimes of states are those of all runs together, however short these are."""

import numpy as np
import pytest

from sim.claims.states import lifetime_of
from sim.dataset.measures.plug import spells


def test_the_lifetime_does_not_depend_on_the_length_of_the_runs():
    """States that end at random after 500 on average, seen in windows of 200, 1,000 and 5,000."""
    rng = np.random.default_rng(2)
    for window, runs in ((200, 2000), (1000, 400), (5000, 80)):
        length = np.full(window // 10, 10.0)
        time, endings = 0.0, 0.0
        for _ in range(runs):
            inside = np.cumsum(rng.random(length.size) < 10.0 / 500.0) % 2 == rng.integers(2)
            _, lived, ended = spells(inside, length)
            time, endings = time + lived, endings + ended
        # What a run shows ends in one spell fewer than it has.
        assert time / endings == pytest.approx(500, rel=0.12)


def test_the_interval_holds_the_lifetime():
    rng = np.random.default_rng(3)
    held = []
    for _ in range(400):
        time = 4000.0
        found = lifetime_of(time, int(rng.poisson(time / 500)))
        held.append(abs(found.nominal_value - 500) < 1.96 * found.std_dev)
    assert np.mean(held) > 0.94


def test_a_state_that_never_ended_lasts_longer_than_a_third_of_the_time():
    assert lifetime_of(3.0, 0) == pytest.approx(3.0 / np.log(20))
