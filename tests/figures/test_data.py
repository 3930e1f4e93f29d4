"""One row per point: means, intervals and regimes, and which points make a curve."""

import numpy as np
import pandas as pd
import pytest

from sim.dataset.replicates import mean_interval
from sim.figures.data import split_curves


def test_students_interval_over_replicates():
    half_width, kind = mean_interval(np.array([1.0, 2.0, 3.0]), np.full(3, 0.9))
    # Tabulated quantile of Student's t with two degrees of freedom at 0.975: 4.30265.
    assert half_width == pytest.approx(4.30265 / np.sqrt(3), rel=1e-5)
    assert kind == "replicates"


def test_replicates_that_agree_by_accident_keep_their_own_intervals():
    half_width, kind = mean_interval(np.array([1.0, 1.0, 1.0, 1.0]), np.full(4, 0.6))
    assert (half_width, kind) == (pytest.approx(0.3), "replicates")


def test_a_single_run_has_its_own_interval():
    assert mean_interval(np.array([1.0]), np.array([0.5])) == (0.5, "within run")


@pytest.mark.parametrize("values", [([], []), ([1.0], [np.nan])])
def test_no_interval_without_an_error(values):
    half_width, kind = mean_interval(*map(np.array, values))
    assert np.isnan(half_width)
    assert kind == "none"


def table(**columns) -> pd.DataFrame:
    return pd.DataFrame(columns)


def test_curves_are_split_by_keys_and_sorted_along_the_axis():
    rows = table(f=[50.0, 20.0, 20.0, 50.0], a=[1.0, 1.0, 2.0, 2.0], friction_plane=[0.0] * 4)
    curves = split_curves(rows, "f", ("a",), ("f", "a"))
    assert [names for names, _ in curves] == [{"a": 1.0}, {"a": 2.0}]
    assert [list(curve["f"]) for _, curve in curves] == [[20.0, 50.0], [20.0, 50.0]]


def test_run_lengths_and_a_plane_like_the_particles_split_nothing():
    rows = table(
        depth=[5.0, 20.0, 5.0],
        friction=[0.4, 0.4, 0.5],
        friction_plane=[0.4, 0.4, 0.5],
        cell=[10.0, 5.0, 10.0],
        transient=[300.0, 900.0, 300.0],
    )
    curves = split_curves(rows, "depth", ("friction",), tuple(rows.columns))
    assert [names for names, _ in curves] == [{"friction": 0.4}, {"friction": 0.5}]


def test_a_plane_of_its_own_friction_splits_a_curve():
    rows = table(depth=[5.0, 5.0], friction=[0.4, 0.4], friction_plane=[0.4, 0.6])
    assert len(split_curves(rows, "depth", ("friction",), tuple(rows.columns))) == 2


def test_a_parameter_that_a_dataset_does_not_know_yet_tells_no_curves_apart():
    rows = table(f=[1.0, 2.0, 1.0, 2.0], a=[1.0, 1.0, 2.0, 2.0])
    curves = split_curves(rows, "f", (), ("f", "a", "later"))
    assert [names for names, _ in curves] == [{"a": 1.0}, {"a": 2.0}]
