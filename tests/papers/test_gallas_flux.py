"""Judges of claims about the mean velocity and about the shear friction coefficient."""

from functools import partial

import pytest

from sim.claims.evidence import Evidence
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPORTED, REPRODUCED, Untestable
from sim.papers.gallas.judges.flux import g1, g2, g8, g13
from sim.papers.gallas.judges.friction import g9, g10, g11, g12, g36
from sim.papers.gallas.judges.onset import g14 as judge_g14
from tests.made.judging import checks_of, headline_bounds, verdict_of
from tests.made.paper_belt import paper_point
from tests.made.results import made_results

#: A judge at another threshold.
g14 = partial(judge_g14, threshold=0.02)

FREQUENCIES = (10, 15, 16, 18, 20, 25, 30, 40, 50, 60, 80, 100)


def rows(name, values, frequencies=(20, 50, 80), **rest):
    """Return points at all frequencies and values of a parameter."""
    return [
        paper_point(**{name: value}, frequency=frequency, **rest)
        for value in values
        for frequency in frequencies
    ]


def base(**rest):
    """Return the row of frequencies with the paper's other parameters."""
    return [paper_point(frequency=frequency, **rest) for frequency in FREQUENCIES]


def replaced(points, scalars, **parameters):
    """Return points, one of them replaced by one with other scalars."""
    new = paper_point(scalars, **parameters)
    assert new.id in {point.id for point in points}
    return [new if point.id == new.id else point for point in points]


def test_rise_with_the_frequency_is_reproduced():
    assert verdict_of(g1, base()) == REPRODUCED


@pytest.mark.parametrize(("frequency", "velocity"), [(25, 0.05), (60, 0.1), (100, 0.9)])
def test_a_dip_or_a_curve_are_not_the_claim(frequency, velocity):
    many = {"replicates": 8}
    points = replaced(base(**many), {"velocity": velocity}, frequency=frequency, **many)
    assert verdict_of(g1, points) == NOT_REPRODUCED


def test_a_dip_between_frequencies_10_hz_apart_is_one_of_the_fine_grid():
    points = replaced(base(replicates=8), {"velocity": 0.05}, replicates=8, frequency=25)
    coarse, fine = checks_of(g1, points)[:2]
    assert (coarse.verdict, fine.verdict) == (REPRODUCED, NOT_REPRODUCED)


def test_creep_below_the_onset_is_reported():
    points = replaced(base(), {"velocity": 0.01}, frequency=10)
    assert verdict_of(g1, points) == REPRODUCED
    assert checks_of(g1, points)[-1].verdict == REPORTED


def test_scattered_velocities_decide_nothing():
    assert verdict_of(g1, base(scatter=1.5, replicates=3)) == INCONCLUSIVE


@pytest.mark.parametrize("missing", [16, 25, 50])
def test_each_frequency_is_needed(missing):
    points = [point for point in base() if point.parameters.frequency != missing]
    with pytest.raises(Untestable, match="frequencies 16, 18, 20"):
        checks_of(g1, points)


def test_flat_vibrations_are_faster():
    points = rows("vibration_angle", (30, 45, 60))
    assert verdict_of(g2, points) == REPRODUCED
    # An order is a trend: one frequency the other way does not undo it.
    odd = replaced(points, {"velocity": 0.5}, frequency=80, vibration_angle=60)
    assert verdict_of(g2, odd) != NOT_REPRODUCED
    swapped = points
    for frequency in {point.parameters.frequency for point in points}:
        for angle, velocity in ((30, 1e-3), (60, 0.5)):
            where = {"frequency": frequency, "vibration_angle": angle}
            swapped = replaced(swapped, {"velocity": velocity}, **where)
    assert verdict_of(g2, swapped) == NOT_REPRODUCED
    assert (
        verdict_of(g2, rows("vibration_angle", (30, 45, 60), scatter=3, replicates=2))
        == INCONCLUSIVE
    )


def test_angles_are_compared_from_20_hz_on_and_with_several_beds():
    points = rows("vibration_angle", (30, 45, 60))
    slow = rows("vibration_angle", (30, 45, 60), frequencies=(16,))
    single = rows("vibration_angle", (30, 45, 60), frequencies=(60,), replicates=1)
    (check,) = checks_of(g2, points + slow + single)
    assert "3 frequencies from 20 Hz on" in check.what
    with pytest.raises(Untestable, match="20 Hz"):
        checks_of(g2, slow + single)


def test_large_amplitudes_are_faster_and_other_damping_is_reported():
    points = rows("amplitude", (0.5, 1, 1.5), (25, 50))
    marker = paper_point(frequency=50, damping=10, shear_damping=10)
    checks = checks_of(g8, [*points, marker])
    assert [check.verdict for check in checks] == [REPRODUCED, REPORTED]
    slow = points
    for frequency in (25, 50):
        slow = replaced(slow, {"velocity": 0.001}, frequency=frequency, amplitude=1.5)
    assert verdict_of(g8, slow) == NOT_REPRODUCED
    with pytest.raises(Untestable, match="amplitudes"):
        checks_of(g8, rows("amplitude", (0.5, 1)))


STIFF = (500, 700, 1000, 2000, 5000)


def test_stiffness_hardly_matters():
    points = rows("stiffness", STIFF)
    assert verdict_of(g13, points) == REPRODUCED
    changed = replaced(points, {"velocity": 0.4}, frequency=80, stiffness=5000)
    assert verdict_of(g13, changed) == NOT_REPRODUCED
    assert verdict_of(g13, rows("stiffness", STIFF, scatter=0.2)) == INCONCLUSIVE
    with pytest.raises(Untestable, match="no stiffness above 500"):
        checks_of(g13, rows("stiffness", (500, 1000)))


def test_with_the_restitution_kept_stiffer_beads_are_compared_with_the_usual_ones():
    usual = [paper_point({"velocity": 0.1}, frequency=f) for f in (20, 50, 80)]
    stiff = {"stiffness_keeps": "restitution"}
    stiffer = [
        paper_point({"velocity": 0.1}, frequency=f, stiffness=y, **stiff)
        for f in (20, 50, 80)
        for y in (700, 2000, 5000)
    ]
    evidence = Evidence(made_results(*usual, *stiffer), "published", stiff)
    judged = g13(evidence, **headline_bounds(g13))
    checks = [check for check in judged if check.what.startswith("change of V")]
    assert len(checks) == 9 and {check.verdict for check in checks} == {REPRODUCED}


def test_a_stiffness_that_was_not_run_leaves_the_claim_open():
    points = rows("stiffness", (500, 1000, 2000, 5000))
    assert verdict_of(g13, points) == INCONCLUSIVE
    assert "Y = 700 was not run" in {check.withheld for check in checks_of(g13, points)}


def test_the_limit_of_the_stiffness_is_reported():
    points = replaced(rows("stiffness", STIFF), {"velocity": 0.1}, frequency=20, stiffness=500)
    assert verdict_of(g13, points) == REPRODUCED


def test_what_is_weak_is_a_number_of_ours():
    usual = paper_point(frequency=80).scalars["velocity"].mean()
    slower = {"velocity": 0.88 * usual}
    points = replaced(rows("stiffness", STIFF), slower, frequency=80, stiffness=2000)
    assert verdict_of(g13, points) == REPRODUCED
    assert verdict_of(partial(g13, max_change=0.1), points) == NOT_REPRODUCED


def test_a_denser_bed_of_stiffer_beads_is_not_the_claim():
    points = rows("stiffness", STIFF)
    dense = paper_point(
        profiles={"number_density": lambda height: 2e6 * (height < 5e-3)},
        frequency=20,
        stiffness=700,
    )
    points = [dense if point.id == dense.id else point for point in points]
    assert verdict_of(g13, points) == NOT_REPRODUCED


def halved(frequencies=(14, 14.5, 15, 15.5, 16, 17, 20, 80), **rest):
    """Return rows of the whole system and of half of it."""
    small = [
        paper_point(frequency=frequency, beads=100, width=10, **rest) for frequency in frequencies
    ]
    return small + [paper_point(frequency=frequency, **rest) for frequency in frequencies]


def test_half_the_system_is_enough():
    assert verdict_of(g14, halved()) == REPRODUCED
    slow = replaced(halved(), {"velocity": 0.2}, frequency=80, beads=100, width=10)
    assert verdict_of(g14, slow) == NOT_REPRODUCED
    early = replaced(halved(), {"velocity": 0.05}, frequency=14.5, beads=100, width=10)
    early = replaced(early, {"velocity": 0.05}, frequency=15, beads=100, width=10)
    early = replaced(early, {"velocity": 0.05}, frequency=15.5, beads=100, width=10)
    assert verdict_of(g14, early) == NOT_REPRODUCED
    with pytest.raises(Untestable, match="100 beads"):
        checks_of(g14, base())


SHEAR = (0, 10, 20, 50, 100)


def line(velocities=None, values=SHEAR, frequencies=(20, 50), **rest):
    """Return points along the shear friction coefficient, with velocities (m/s) if given."""
    scalars_by_value = (
        [None] * len(values) if velocities is None else [{"velocity": v} for v in velocities]
    )
    return [
        paper_point(scalars, frequency=frequency, shear_damping=shear, **rest)
        for frequency in frequencies
        for shear, scalars in zip(values, scalars_by_value, strict=True)
    ]


def test_fast_rise_then_gentle():
    assert verdict_of(g9, line()) == REPRODUCED
    slow = [0, 0.05, 0.06, 0.08, 0.1]
    assert verdict_of(g9, line(slow)) == NOT_REPRODUCED
    falling = [0, 0.1, 0.1, 0.095, 0.09]
    assert verdict_of(g9, line(falling)) == NOT_REPRODUCED
    assert verdict_of(g9, line(scatter=0.4)) == INCONCLUSIVE
    with pytest.raises(Untestable, match="shear_damping 20"):
        checks_of(g9, line(values=(0, 10, 50, 100)))


@pytest.mark.parametrize("judge", [g9, g36])
def test_velocities_that_drift_decide_nothing(judge):
    """By 12 % in 100 cycles at 20 Hz, by 5 % at 50 Hz."""
    values = (0, 10, 20, 50, 100)
    drift = {"acceleration": 0.0025, "acceleration_half_width": 1e-5}
    points = [
        paper_point({"velocity": 0.1 + shear / 1e4} | drift, frequency=f, shear_damping=shear)
        for f in (20, 50, 80)
        for shear in values
    ]
    assert verdict_of(judge, points) == INCONCLUSIVE
    assert all("longer runs" in check.withheld for check in checks_of(judge, points))


@pytest.mark.parametrize(("half_width", "verdict"), [(1e-6, REPRODUCED), (2e-3, INCONCLUSIVE)])
def test_velocities_must_be_known_not_to_drift(half_width, verdict):
    steady = {"acceleration": 0.0, "acceleration_half_width": half_width}
    points = [
        paper_point({"velocity": velocity} | steady, frequency=f, shear_damping=shear)
        for f in (20, 50)
        for shear, velocity in ((0, 0.0), (10, 0.1), (20, 0.102), (50, 0.105), (100, 0.108))
    ]
    assert verdict_of(g9, points) == verdict


def test_beads_that_do_not_move_have_no_slope():
    assert verdict_of(g9, line([0, 0.1, -0.1, 0.1, 0.1])) == INCONCLUSIVE


def still(velocities, frequencies=(20, 50)):
    """Return points without shear friction, velocities (m/s) per bed, and the usual points."""
    free = [
        paper_point({"velocity": velocities}, frequency=frequency, shear_damping=0)
        for frequency in frequencies
    ]
    return [*free, *(paper_point(frequency=frequency) for frequency in (20, 50))]


@pytest.mark.parametrize(
    ("velocities", "verdict"),
    [
        ([0.001, -0.001, 0.002, -0.002, 0.0005], REPRODUCED),
        # More beds make a small velocity no larger.
        ([0.001, 0.0011, 0.0009, 0.001, 0.001], REPRODUCED),
        ([0.05, 0.051, 0.049, 0.05, 0.05], NOT_REPRODUCED),
        ([0.05, -0.05, 0.04, -0.06, 0.02], INCONCLUSIVE),
    ],
)
def test_no_shear_friction_no_transport(velocities, verdict):
    assert verdict_of(g10, still(velocities)) == verdict


def test_no_transport_needs_runs_without_shear_friction():
    with pytest.raises(Untestable, match="frequency 50, shear_damping 0"):
        checks_of(g10, still([0.0, 0.001], frequencies=(20,)))


def scattered(ratio, **rest):
    """Return points whose relative scatter below g is ``ratio`` times that at 50g."""
    usual = line(values=(50,), scatter=0.01, **rest)
    return usual + line(values=(0.2, 0.5), scatter=0.01 * ratio, **rest)


@pytest.mark.parametrize(
    ("ratio", "verdict"), [(20, REPRODUCED), (0.8, NOT_REPRODUCED), (2, INCONCLUSIVE)]
)
def test_poor_statistics_at_small_shear_friction(ratio, verdict):
    assert verdict_of(g11, scattered(ratio)) == verdict


def test_scatter_needs_several_beds():
    with pytest.raises(Untestable, match="scatter over several beds"):
        checks_of(g11, scattered(5, replicates=1))
    with pytest.raises(Untestable, match="γ_s < g"):
        checks_of(g11, line())


@pytest.mark.parametrize(
    ("velocity", "scatter", "verdict"),
    [
        (0.25, 0.001, REPRODUCED),
        (0.4, 0.001, NOT_REPRODUCED),
        (0.25, 0.2, INCONCLUSIVE),
    ],
)
def test_strong_shear_friction_hardly_matters(velocity, scatter, verdict):
    usual = paper_point({"velocity": 0.25}, frequency=80, scatter=scatter)
    strong = paper_point({"velocity": velocity}, frequency=80, shear_damping=100, scatter=scatter)
    assert verdict_of(g12, [usual, strong]) == verdict
    with pytest.raises(Untestable, match="shear_damping 100"):
        checks_of(g12, [usual])


def test_shear_friction_matters_at_small_velocities():
    values = (20, 50, 100)
    assert verdict_of(g36, line(values=values, frequencies=(20, 80))) == REPRODUCED
    slow = line([0.1, 0.1, 0.1], values, frequencies=(20,))
    fast = line([0.2, 0.25, 0.3], values, frequencies=(80,))
    assert verdict_of(g36, slow + fast) == NOT_REPRODUCED
    # A fast flow that γ_s slows is changed as well.
    falling = line([0.3, 0.25, 0.2], values, frequencies=(80,))
    assert verdict_of(g36, slow + falling) == NOT_REPRODUCED
    assert verdict_of(g36, line(values=values, frequencies=(20, 80), scatter=0.1)) == INCONCLUSIVE
    with pytest.raises(Untestable, match="frequency 80"):
        checks_of(g36, line(values=values, frequencies=(20,)))
