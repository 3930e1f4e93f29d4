"""Judges of claims about velocity and agitation over height, and about density waves."""

import numpy as np
import pytest

from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    REPRODUCED,
    Untestable,
    combined_verdict,
)
from sim.papers.gallas.judges.velocity import g21, g22, g23, g29, g30
from tests.made.judging import checks_of, verdict_of
from tests.made.paper_belt import BEAD, paper_point, temperature_profile, velocity_profile

FREQUENCIES = (10, 20, 60, 80)


def row(frequencies=FREQUENCIES, profiles=None, **rest):
    """Return points at several frequencies; ``profiles`` replaces profiles by frequency."""
    return [
        paper_point(profiles=(profiles or {}).get(frequency), frequency=frequency, **rest)
        for frequency in frequencies
    ]


def test_a_plateau_of_velocity():
    def parts(points):
        checks = checks_of(g21, points)
        return [combined_verdict(check for check in checks if check.part == part) for part in "abc"]

    young = paper_point(frequency=80, damping=10, shear_damping=10)
    assert parts([*row(), young]) == [REPRODUCED] * 3
    shear = {60: {"velocity_profile": lambda height: 0.02 * height / BEAD}}
    assert parts([*row(profiles=shear), young])[0] == NOT_REPRODUCED
    fast = velocity_profile(paper_point(frequency=60).parameters, lag=-0.3)
    ends = {60: {"velocity_profile": fast}}
    assert parts([*row(profiles=ends), young]) == [REPRODUCED, NOT_REPRODUCED, NOT_REPRODUCED]
    # Of runs that have relaxed no fall is asked for.
    assert {check.part for check in checks_of(g21, row())} == {"a", "b"}
    with pytest.raises(Untestable, match="frequency 80"):
        checks_of(g21, row((20, 60)))


def faster_at_the_top(frequency):
    """Return a velocity over height that rises at the top instead of falling there."""
    usual = paper_point(frequency=frequency)
    slow, fast = (velocity_profile(usual.parameters, lag) for lag in (0.3, -0.3))
    return lambda z: np.where(z > 10 * BEAD, fast(z), slow(z))


@pytest.mark.parametrize("frequency", [20, 60, 80])
def test_velocities_fall_at_the_top_at_all_frequencies(frequency):
    young = paper_point(frequency=80, damping=10, shear_damping=10)
    contrary = {frequency: {"velocity_profile": faster_at_the_top(frequency)}}
    checks = checks_of(g21, [*row(profiles=contrary), young])
    votes = [check for check in checks if check.part == "c"]
    assert [check.value > 1 for check in votes] == [f == frequency for f in (20, 60, 80)] + [False]
    assert combined_verdict(votes) == NOT_REPRODUCED


def test_a_plateau_with_waves_of_their_own_in_each_bed_decides_nothing():
    heights = (np.arange(200) + 0.5) * BEAD
    waves = [0.2 * (1 + size * np.sin(heights / BEAD * 2)) for size in (0.2, -0.2, 0.3, -0.1, 0.05)]
    profiles = {60: {"velocity_profile": np.array(waves)}}
    assert verdict_of(g21, row(profiles=profiles)) == INCONCLUSIVE


def started(fast_lag=0.0, long_lag=0.1, short_lag=0.4, initial=20.0, scatter=1e-3):
    """Return runs from rest under both protocols, and fast starts, with lags at the top."""
    points = []
    for damping in (10, 50):
        where = {"frequency": 80, "damping": damping, "shear_damping": damping, "scatter": scatter}
        for lag, rest in (
            (short_lag, {"protocol": "published"}),
            (long_lag, {"protocol": "converged"}),
            (fast_lag, {"protocol": "published", "initial_velocity": initial}),
        ):
            usual = paper_point(**where, **rest)
            profile = velocity_profile(usual.parameters, lag)
            points.append(paper_point(profiles={"velocity_profile": profile}, **where, **rest))
    return points


def test_unfinished_relaxation():
    assert verdict_of(g22, started()) == REPRODUCED
    assert verdict_of(g22, started(fast_lag=0.3)) == NOT_REPRODUCED
    assert verdict_of(g22, started(fast_lag=-0.3)) == NOT_REPRODUCED
    assert verdict_of(g22, started(long_lag=0.6)) == NOT_REPRODUCED


def test_relaxation_needs_both_protocols_and_a_start_that_is_fast():
    with pytest.raises(Untestable, match="started faster"):
        checks_of(g22, started(initial=0.1))
    without = [point for point in started() if point.parameters.protocol == "published"]
    with pytest.raises(Untestable, match="converged"):
        checks_of(g22, without)


def angles(values=(30, 45, 60, 90), **rest):
    """Return points at several angles."""
    return [paper_point(frequency=60, vibration_angle=angle, **rest) for angle in values]


def test_plateau_against_frequency_and_angle():
    points = [*row((10, 20, 80)), *angles()]
    assert verdict_of(g23, points) == REPRODUCED
    even = {f: {"velocity_profile": lambda z, v=v: v + 0 * z} for f, v in ((10, 1.0), (80, 1e-4))}
    slow = [*row((10, 20, 80), even), *angles()]
    assert verdict_of(g23, slow) == NOT_REPRODUCED
    few = {"scatter": 3, "replicates": 2}
    noisy = [*row((10, 20, 80), **few), *angles(**few)]
    assert verdict_of(g23, noisy) == INCONCLUSIVE
    with pytest.raises(Untestable, match="vibration_angle 90"):
        checks_of(g23, [*row((10, 20, 80)), *angles((30, 45, 60))])


def test_the_surface_becomes_fluid_first():
    assert verdict_of(g29, row((18, 20))) == REPRODUCED
    cold = {20: {"fluctuation_temperature_profile": lambda height: 0.05 * np.exp(-height / BEAD)}}
    assert verdict_of(g29, row((18, 20), cold)) == NOT_REPRODUCED
    with pytest.raises(Untestable, match="frequency 18"):
        checks_of(g29, row((20,)))


def test_a_few_stray_beads_above_the_surface_hide_no_temperature():
    usual = paper_point(frequency=20)
    hot = temperature_profile(usual.parameters)(usual.height)
    above = usual.profiles["number_density"] < 1e-3 * usual.profiles["number_density"].max()
    points = row((18, 20), {20: {"fluctuation_temperature_profile": np.where(above, np.nan, hot)}})
    assert verdict_of(g29, points) == REPRODUCED
    lacking = np.where(usual.height > 13 * BEAD, np.nan, hot)
    points = row((18, 20), {20: {"fluctuation_temperature_profile": lacking}})
    assert verdict_of(g29, points) == INCONCLUSIVE


def test_a_surface_that_is_hot_in_some_beds_alone_decides_nothing():
    usual = paper_point(frequency=20)
    hot = temperature_profile(usual.parameters)(usual.height)
    some = np.array([hot, hot, hot, np.full_like(hot, 0.02), np.full_like(hot, 0.02)])
    points = row((18, 20), {20: {"fluctuation_temperature_profile": some}})
    assert verdict_of(g29, points) == INCONCLUSIVE


def waves(early, later=2.0, **rest):
    """Return points with a power of density waves in the first cycles, and another later."""
    usual = {"early_wave_power": early, "wave_power": later}
    loose = {"vibration_angle": 30, "damping": 10, "shear_damping": 10}
    return [
        paper_point(usual, frequency=40, **rest),
        paper_point(usual, frequency=40, **loose, **rest),
    ]


@pytest.mark.parametrize(
    ("early", "scatter", "verdict"),
    [(4.0, 0.01, REPRODUCED), (1.6, 0.01, NOT_REPRODUCED), (2.2, 0.5, INCONCLUSIVE)],
)
def test_density_waves_at_the_start(early, scatter, verdict):
    assert verdict_of(g30, waves(early, scatter=scatter)) == verdict


def test_density_waves_count_the_first_cycles_of_all_beds():
    few = waves(1.6, scatter=0.01, replicates=4, protocol="converged")
    assert verdict_of(g30, few, protocol="converged") == NOT_REPRODUCED
    # The published beds begin as the converged ones do, and there are more of them.
    many = waves(1.6 + np.r_[np.zeros(4), np.full(8, 1.2)], scatter=0, replicates=12)
    assert verdict_of(g30, [*few, *many], protocol="converged") == REPRODUCED


def test_density_waves_need_both_beds():
    with pytest.raises(Untestable, match="vibration_angle 30"):
        checks_of(g30, waves(4.0)[:1])
