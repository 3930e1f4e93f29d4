"""Checks: which verdict follows from a value, its interval, its thresholds and its samples."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from scipy.special import stdtrit
from uncertainties import ufloat

from sim.claims.checks import above, below, within
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    REPORTED,
    REPRODUCED,
    SIGMAS,
    Check,
    together,
)


@pytest.mark.parametrize(
    ("value", "half_width", "verdict"),
    [
        (2.0, 0.5, REPRODUCED),
        (2.0, 1.0, INCONCLUSIVE),
        (1.2, 0.3, INCONCLUSIVE),
        (0.5, 0.4, NOT_REPRODUCED),
        (0.5, 0.5, NOT_REPRODUCED),
        (1.0, 0.0, NOT_REPRODUCED),
        (nan, 0.1, INCONCLUSIVE),
        (2.0, inf, INCONCLUSIVE),
    ],
)
def test_an_interval_clear_of_the_threshold_decides(value, half_width, verdict):
    assert Check("x", value, half_width, 1.0, inf).verdict == verdict
    assert Check("x", -value, half_width, -inf, -1.0).verdict == verdict


@pytest.mark.parametrize(
    ("value", "verdict"), [(0.0, REPRODUCED), (0.95, INCONCLUSIVE), (-1.2, NOT_REPRODUCED)]
)
def test_two_thresholds(value, verdict):
    assert Check("x", value, 0.1, -1.0, 1.0).verdict == verdict


@pytest.mark.parametrize("samples", [0, 7, nan])
def test_too_few_samples_decide_nothing(samples):
    assert Check("x", 2.0, 0.1, 1.0, inf, samples=samples).verdict == INCONCLUSIVE


def test_helpers_turn_standard_deviations_into_intervals():
    measured = ufloat(2.0, 0.25)
    assert above("x", measured, 1.0).half_width == pytest.approx(0.49)
    assert above("x", measured, 1.0).verdict == below("x", measured, 3.0).verdict == REPRODUCED
    assert within("x", measured, 1.0, 2.2).verdict == INCONCLUSIVE
    assert below("x", 2, 1.5).verdict == NOT_REPRODUCED


HOLDS, FAILS, OPEN = (Check("x", value, 0.1, 0.0, 1.0) for value in (0.5, 2.0, 1.0))
BARELY = Check("x", 1.11, 0.1, 0.0, 1.0)
CLEARLY = Check("x", 1.3, 0.1, 0.0, 1.0)
TOLD = Check("x", 1.0, inf, -inf, inf)


@pytest.mark.parametrize(
    ("checks", "verdict"),
    [
        ([HOLDS, HOLDS], REPRODUCED),
        ([HOLDS, OPEN], INCONCLUSIVE),
        ([HOLDS, OPEN, FAILS], NOT_REPRODUCED),
        ([HOLDS, TOLD], REPRODUCED),
        ([BARELY], NOT_REPRODUCED),
        ([BARELY, *[HOLDS] * 9], INCONCLUSIVE),
        ([CLEARLY, *[HOLDS] * 9], NOT_REPRODUCED),
        ([replace(CLEARLY, freedom=1), *[HOLDS] * 9], INCONCLUSIVE),
        ([TOLD], INCONCLUSIVE),
        ([], INCONCLUSIVE),
    ],
)
def test_all_checks_must_hold_and_one_must_fail_as_one_of_so_many(checks, verdict):
    assert together(checks) == verdict


def test_what_is_only_reported_decides_nothing():
    assert TOLD.verdict == REPORTED


def test_few_replicates_seldom_fail_by_chance_however_many_checks_there_are():
    """Of twenty quantities that are all at the edge, one in twenty claims fails at most."""
    rng, claims = np.random.default_rng(5), 400
    values = rng.normal(size=(claims, 20, 3))
    means, errors = values.mean(axis=2), values.std(axis=2, ddof=1) / np.sqrt(3)
    widths = stdtrit(2, 0.975) * errors
    failed = 0
    for mean, width in zip(means, widths, strict=True):
        pairs = zip(mean, width, strict=True)
        checks = [Check("x", each, half, 0.0, inf, freedom=2.0) for each, half in pairs]
        failed += together(checks) == NOT_REPRODUCED
    assert failed / claims < 0.05


def test_half_widths_are_told_in_the_deviations_of_tables():
    assert SIGMAS == 1.96
