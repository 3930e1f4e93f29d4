"""Means and intervals of points, and which points make a curve."""

import numpy as np
import pandas as pd
import pytest

from sim.dataset.replicates import mean_interval
from sim.figures.data import split_curves


@pytest.mark.parametrize(
    ("values", "errors", "half_width", "kind"),
    [
        # Tabulated quantile of Student's t with two degrees of freedom at 0.975: 4.30265.
        ([1.0, 2.0, 3.0], [0.9] * 3, 4.30265 / np.sqrt(3), "replicates"),
        # Replicates that agree by accident keep their own intervals.
        ([1.0] * 4, [0.6] * 4, 0.3, "replicates"),
        ([1.0], [0.5], 0.5, "within run"),
        ([], [], np.nan, "none"),
        ([1.0], [np.nan], np.nan, "none"),
    ],
)
def test_an_interval_is_students_or_that_within_a_run(values, errors, half_width, kind):
    found = mean_interval(np.array(values), np.array(errors))
    assert found == (pytest.approx(half_width, rel=1e-5, nan_ok=True), kind)


@pytest.mark.parametrize(
    ("columns", "keys", "expected"),
    [
        (
            {"depth": [50, 20, 20, 50], "a": [1, 1, 2, 2], "friction_plane": [0] * 4},
            ["a"],
            [{"a": 1}, {"a": 2}],
        ),
        # Run lengths, and a plane like the particles, split nothing.
        (
            {
                "depth": [5, 20, 5],
                "friction": [0.4, 0.4, 0.5],
                "friction_plane": [0.4, 0.4, 0.5],
                "cell": [10, 5, 10],
                "transient": [300, 900, 300],
            },
            ["friction"],
            [{"friction": 0.4}, {"friction": 0.5}],
        ),
        (
            {"depth": [5, 5], "friction": [0.4, 0.4], "friction_plane": [0.4, 0.6]},
            ["friction"],
            [{"friction": 0.4, "friction_plane": plane} for plane in (0.4, 0.6)],
        ),
    ],
)
def test_curves_are_split_by_keys_and_what_varies_and_sorted_along_the_axis(
    columns, keys, expected
):
    curves = split_curves(pd.DataFrame(columns), "depth", keys, tuple(columns))
    assert [names for names, _ in curves] == expected
    assert all(curve["depth"].is_monotonic_increasing for _, curve in curves)
