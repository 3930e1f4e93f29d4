"""What the replicates of a point say together."""

import numpy as np
import pytest

from sim.base.statistics import student_half_width
from sim.dataset.replicates import outcome, velocity_interval


def point(regimes, velocities=None):
    count = len(regimes)
    words = {
        name: np.full(count, word, object)
        for name, word in (
            ("quality", "reliable"),
            ("stopped", "length"),
            ("reason", ""),
            ("status", "completed"),
        )
    }
    return words | {
        "regime": np.array(regimes, object),
        "velocity": np.array(velocities or [1.0] * count),
        "velocity_half_width": np.full(count, 1e-3),
    }


def test_the_interval_over_replicates_is_students():
    """Of 1, 2, 3: the standard deviation is 1, the quantile of two degrees of freedom 4.3027."""
    assert student_half_width(np.array([1.0, 2.0, 3.0])) == pytest.approx(
        4.30265 / 3**0.5, rel=1e-5
    )
    half_width, kind = velocity_interval(np.array([1.0, 2.0, 3.0]), np.full(3, 1e-3))
    assert (half_width, kind) == (pytest.approx(4.30265 / 3**0.5, rel=1e-5), "replicates")


def test_replicates_that_agree_by_accident_know_no_more_than_each_of_itself():
    half_width, _ = velocity_interval(np.array([1.0, 1.0]), np.array([0.3, 0.4]))
    assert half_width == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("regimes", "together"),
    [
        (["steady", "steady"], "steady"),
        (["steady", "accelerating"], "mixed"),
        (["steady", "undetermined"], "steady"),
        (["steady", "undetermined", "undetermined"], "undetermined"),
        (["undetermined"], "undetermined"),
    ],
)
def test_replicates_that_contradict_each_other_are_mixed(regimes, together):
    assert outcome(point(regimes))["regime"] == together
