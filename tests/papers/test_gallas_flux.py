"""Judges of claims about the mean velocity, on belts that follow the paper and on others."""

from functools import partial

import pytest

from sim.claims.evidence import Evidence
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPORTED, REPRODUCED, Untestable
from sim.papers.gallas.judges.flux import g1, g2, g8, g13
from sim.papers.gallas.judges.onset import g14 as judge_g14
from tests.made.judging import checks_of, headline_bounds, verdict_of
from tests.made.paper_belt import paper_point
from tests.made.results import made_results

#: The judge of the other reading, on frequencies in fine steps.
fine_g1 = partial(g1, step=2)

#: A judge at another threshold.
g14 = partial(judge_g14, threshold=0.02)

FREQUENCIES = (10, 15, *range(16, 31, 2), 25, 40, 50, 60, 80, 100)


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
    assert verdict_of(fine_g1, points) == NOT_REPRODUCED
    # On frequencies 10 Hz apart a dip between them does not show.
    assert verdict_of(g1, points) == (REPRODUCED if frequency == 25 else NOT_REPRODUCED)


def test_a_dip_between_frequencies_10_hz_apart_is_one_of_the_fine_grid():
    points = replaced(base(replicates=8), {"velocity": 0.05}, replicates=8, frequency=25)
    coarse, shown = checks_of(g1, points)[:2]
    assert (coarse.verdict, shown.verdict) == (REPRODUCED, REPORTED)
    fine = checks_of(fine_g1, points)[0]
    assert fine.verdict == NOT_REPRODUCED and fine.what == shown.what
    assert "; falls from 20 Hz to 25 Hz by " in fine.text and fine.text.endswith(" m/s")
    assert not coarse.text


def test_a_fine_grid_of_too_wide_steps_decides_nothing():
    """From 20 to 30 Hz the grid is one of 5 Hz: a fall between may be missed, or not be one."""
    wide = [
        point for point in base(replicates=8) if point.parameters.frequency not in (22, 24, 26, 28)
    ]
    for points in (wide, replaced(wide, {"velocity": 0.05}, replicates=8, frequency=25)):
        fine, coarse = checks_of(fine_g1, points)[:2]
        assert (coarse.verdict, fine.verdict) == (REPORTED, INCONCLUSIVE)
        assert verdict_of(g1, points) == REPRODUCED
        assert fine.withheld == "frequencies up to 2 Hz apart"
    # Above 30 Hz any steps will do.
    gap = [point for point in base() if point.parameters.frequency != 28]
    assert verdict_of(fine_g1, gap) == INCONCLUSIVE


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
    check, likely = checks_of(g2, points + slow + single)
    assert likely.verdict == REPORTED and likely.value == 1
    assert "3 frequencies from 20 Hz on" in check.what
    with pytest.raises(Untestable, match="20 Hz"):
        checks_of(g2, slow + single)


def test_large_amplitudes_are_faster_and_other_damping_is_reported():
    points = rows("amplitude", (0.5, 1, 1.5), (25, 50))
    marker = paper_point(frequency=50, damping=10, shear_damping=10)
    checks = checks_of(g8, [*points, marker])
    assert [check.verdict for check in checks] == [REPRODUCED, REPORTED, REPORTED]
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
