"""The probability of regimes is right as often as it says."""

import numpy as np
import pytest

from sim.surrogates.fit import Regimes
from tests.made.surrogates import design


def three(x):
    """Return the regimes of three parts of the unit cube."""
    words = np.where(x[:, 0] + 0.3 * x[:, 1] < 0.4, "arrested", "steady").astype(object)
    return np.where(x[:, 0] > 0.7, "accelerating", words)


def test_probabilities_are_right_as_often_as_they_say():
    """Over 6 made-up studies; a probability that is too sure or too vague would differ by more."""
    said, right = [], []
    for seed in range(6):
        x = design(32, 2, seed)
        regimes = Regimes.fit(x, three(x))
        fresh = np.random.default_rng(seed).random((300, 2))
        chances = regimes.predict(fresh)
        assert chances.sum(axis=0) == pytest.approx(1)
        likeliest = np.array(regimes.names)[chances.argmax(axis=0)]
        said.append(chances.max(axis=0).mean())
        right.append((likeliest == three(fresh)).mean())
    assert np.mean(right) > 0.9
    assert abs(np.mean(said) - np.mean(right)) < 0.05


def test_a_regime_that_depends_on_chance_has_no_sharp_boundary():
    rng = np.random.default_rng(1)
    x = design(64, 2)
    words = np.where(rng.random(64) < 0.5, "steady", "arrested").astype(object)
    chances = Regimes.fit(x, words).predict(rng.random((100, 2)))
    assert np.abs(chances - 0.5).mean() < 0.25


def test_one_regime_is_certain_and_unknown_ones_count_for_nothing():
    x = design(8, 2)
    words = np.array(["steady"] * 6 + ["undetermined", "failed"], object)
    regimes = Regimes.fit(x, words)
    assert regimes.names == ("steady",)
    assert (regimes.predict(x) == 1).all()
    nothing = Regimes.fit(x, np.full(8, "undetermined", object))
    assert nothing.predict(x).shape == (0, 8)


def test_what_the_mean_counts_is_a_regime_of_its_own():
    x = np.linspace(0, 1, 12)[:, None]
    words = np.array(["undetermined"] * 9 + ["accelerating"] * 3, object)
    assert Regimes.fit(x, words).names == ("accelerating",)
    regimes = Regimes.fit(x, words, ("steady", "undetermined"))
    assert regimes.names == ("accelerating", "undetermined")
    left, right = regimes.predict(np.array([[0.1], [0.95]])).T
    assert left[1] > 0.9 and right[0] > 0.5 and left.sum() == pytest.approx(1)
