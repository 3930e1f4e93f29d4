"""Intervals of sensitivities hold the truth in nine of ten cases and more, or there are none."""

import numpy as np
import pytest

from tests.coverage.sensitivity import RUNS, SURROGATES, coverage


@pytest.mark.long
@pytest.mark.parametrize("name", [*SURROGATES, *RUNS])
def test_intervals_hold_the_truth_or_there_is_no_answer(name):
    _, answered, held = coverage(name)
    assert not answered or np.mean(held) >= 0.9
