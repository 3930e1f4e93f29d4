"""What runs say of a point: mean, error, regime, and the scatter between replicates."""

from dataclasses import replace

import numpy as np
import pytest

from sim.study.design import Axis
from sim.surrogates.answers import Refusal
from sim.surrogates.sample import omissions, points_of_mean, sample_points, standard_errors
from tests.made.results import made_point, made_results
from tests.made.surrogates import asked, design

SPEC = asked((Axis("friction", 0.3, 0.6),), series="flows")


def test_errors_of_replicates_that_agree_by_accident_are_moderated():
    """Variances of 3 replicates scatter by a factor; the errors must do so by less, about truth."""
    rng = np.random.default_rng(1)
    values = list(rng.normal(1, 0.3, (200, 3)))
    errors, is_unknown = standard_errors(values, np.zeros(200), design(200, 2))
    raw = np.array([row.std(ddof=1) for row in values]) / np.sqrt(3)
    assert not is_unknown
    assert errors.min() > 2 * raw.min() and errors.std() < 0.3 * raw.std()
    assert np.sqrt((errors**2).mean()) == pytest.approx(0.3 / np.sqrt(3), rel=0.1)


def test_a_single_replicate_has_the_common_scatter():
    rng = np.random.default_rng(1)
    values = [*rng.normal(1, 0.3, (30, 3)), np.array([1.2])]
    errors, is_unknown = standard_errors(values, np.full(31, 0.01), design(31, 2))
    assert not is_unknown and errors[-1] == pytest.approx(0.3, rel=0.2)


def test_without_replicates_the_scatter_is_unknown():
    errors, is_unknown = standard_errors([np.array([1.0])] * 5, np.full(5, 0.02), design(5, 2))
    assert is_unknown and errors == pytest.approx(0.02)
    alike, is_unknown = standard_errors([np.ones(3)] * 5, np.full(5, 0.02), design(5, 2))
    assert not is_unknown and alike == pytest.approx(0.02)


#: Slope of the velocity (m/s²), half width of its interval, and value of the observable of a point
#: of an undetermined regime, and what answers make of it.
UNDETERMINED = [
    (-0.01, 0.02, 1.0, "counts"),
    (0.01, 0.005, 1.0, "counts"),
    (-0.01, 0.005, 1.0, "slowing"),
    (-0.01, 0.02, np.nan, "without a value"),
    (-0.01, 0.005, np.nan, "without a value"),
]


def sample_of(regime: str, cases=UNDETERMINED, velocity=1.0):
    points = [
        made_point(
            "chute",
            {
                "velocity": velocity,
                "shear_depth": value,
                "regime": regime,
                "acceleration": slope * np.sign(velocity),
                "acceleration_half_width": half_width,
                "independent_samples": 2.0,
                "wall_time": 1.0,
                "loop_time": 1.0,
            },
            friction=0.3 + 0.01 * number,
            replicates=1,
        )
        for number, (slope, half_width, value, _) in enumerate(cases)
    ]
    results = made_results(*points)
    series = ("point", np.full(len(points), "flows", object))
    results = replace(results, dataset=results.dataset.assign_coords(series=series))
    return sample_points(results, SPEC.with_values(observable="shear_depth"))


@pytest.mark.parametrize("velocity", [1.0, -1.0])
def test_flows_too_short_to_tell_count_unless_they_surely_slow_down(velocity):
    sample = sample_of("undetermined", velocity=velocity)
    told = [case[-1] for case in UNDETERMINED]
    assert points_of_mean(sample, SPEC.mean_regimes).tolist() == [one == "counts" for one in told]
    assert omissions(sample, SPEC.mean_regimes) == "1 slowing, 2 without a value"
    assert points_of_mean(sample, (*SPEC.mean_regimes, "slowing")).sum() == 3
    assert points_of_mean(sample, ("steady", "mixed")).sum() == 0
    resting = sample_of("arrested", UNDETERMINED[:1])
    assert omissions(resting, SPEC.mean_regimes) == "1 arrested"


def sample_with(**scalars):
    made = made_results(made_point("chute", {"velocity": 1.0} | scalars, scatter=0.0, threads=4))
    series = ("point", np.array(["flows"], object))
    results = replace(made, dataset=made.dataset.assign_coords(series=series))
    return sample_points(results, SPEC)


def hours_of(**scalars) -> np.ndarray:
    return sample_with(**scalars)["core_hours"].values


@pytest.mark.parametrize("size", [1e140, 1e-140])
def test_values_of_an_odd_size_are_refused_by_name(size):
    with pytest.raises(Refusal, match=r"no mean, as velocity is 1e.140 at most; allowed: between"):
        sample_with(velocity=size)


def test_hours_are_those_of_the_processor_however_busy_the_machine_was():
    """Five replicates of 72 s each; a run that does not tell its loop has used four threads."""
    assert hours_of(wall_time=90.0, loop_time=72.0) == pytest.approx(0.1)
    assert hours_of(wall_time=900.0, loop_time=72.0) == pytest.approx(0.1)
    assert hours_of(wall_time=18.0) == hours_of(wall_time=18.0, loop_time=np.nan)
    assert hours_of(wall_time=18.0) == pytest.approx(0.1)


def test_errors_follow_a_noise_that_rises_along_a_parameter():
    """Few replicates: each error must be about the noise there, not that of all points."""
    rng, x = np.random.default_rng(1), design(64, 2)
    size = 0.01 * 30 ** x[:, 0]
    errors, _ = standard_errors(list(rng.normal(1, size[:, None], (64, 3))), np.zeros(64), x)
    ratios = errors * np.sqrt(3) / size
    for third in (x[:, 0] < 1 / 3, x[:, 0] > 2 / 3):
        assert 0.7 < np.sqrt(np.mean(ratios[third] ** 2)) < 1.4
