"""Intervals hold the truth as often as docs/validation.md says, or there is no answer."""

import numpy as np
import pytest

from tests.coverage import calibration, propagation, sensitivity, surrogates
from tests.coverage.rows import coverage


@pytest.mark.long
@pytest.mark.parametrize(
    "case", calibration.CASES, ids=lambda one: f"{one.name}, {one.measurements}"
)
def test_intervals_of_calibrations_hold_the_truth(case):
    _, answers, held, _ = calibration.row_of(case)
    # Both parameters of a material go together: of 40 materials, 5 or more are missed at 95 % once
    # in 20 times.
    assert calibration.share_held(answers, held) > (0.85 if answers > 20 else 0.7)


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 1])
def test_chains_are_the_posterior_of_a_grid(number):
    _, question = calibration.question(calibration.CASES[number], 1)
    chains = calibration.intervals_of_chains(question)
    grid = calibration.intervals_on_a_grid(question)
    assert chains is not None and grid is not None
    for name in question.names:
        width = np.ptp(question.ranges[name])
        assert chains[name] / width == pytest.approx(grid[name] / width, abs=0.03)


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *((sensitivity, name) for name in (*sensitivity.SURROGATES, *sensitivity.RUNS)),
        *((propagation, name) for name in propagation.CASES),
    ],
)
def test_intervals_of_sensitivities_and_propagations_hold_the_truth(kind, name):
    _, held = coverage(kind.questions(name))
    assert np.mean(held) >= 0.9 if held else kind is sensitivity


@pytest.mark.long
@pytest.mark.parametrize(
    "case", surrogates.CASES, ids=lambda one: f"{one.name}, {one.points} points"
)
def test_intervals_of_surrogates_hold_the_truth(case):
    held, noisy, *_ = surrogates.row_of(case)
    assert not held.size or held.mean() > 0.9
    assert not held.size or not callable(case.noise) or noisy.mean() > 0.9


def test_too_few_points_of_many_give_no_answer():
    (case,) = (one for one in surrogates.CASES if one.name.startswith("4 of 48"))
    assert not surrogates.row_of(case, 2).size
