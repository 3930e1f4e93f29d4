"""Two sides beside each other: which points are the same, and which differ by more than chance."""

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.dataset.compare import Measured, compare, read_measured
from sim.parameters import complete, parse_point
from tests.made.runs import write_run

RNG = np.random.default_rng(5)


def belt(values, own=np.nan, samples=np.nan, **parameters) -> Measured:
    point = parse_point({"system": "belt", **parameters}, "test")
    values = np.atleast_1d(np.asarray(values, float))
    known = [np.full(values.size, each) for each in (own, samples)]
    return Measured("belt", complete(point), values, *known)


def beds(mean, **parameters) -> Measured:
    return belt(mean + 0.01 * RNG.normal(size=8), **parameters)


def side(mean=1.0, **parameters) -> list[Measured]:
    return [beds(mean, frequency=f, **parameters) for f in (20, 30, 40, 50)]


def test_points_are_paired_by_what_varies_and_what_is_constant_is_compared():
    found = compare(side(), side(damping_mass="reduced", seed=7), "velocity", "m s-1")
    assert [pair.key["frequency"] for pair in found.pairs] == [20, 30, 40, 50]
    assert found.differ == {"damping_mass": ("own", "reduced")} and found.alone == (0, 0)
    assert found.real == [False] * 4


def test_means_that_lie_apart_are_told_from_chance():
    other = [*side(1.05)[:2], *side()[2:]]
    found = compare(side(), other, "velocity", "m s-1")
    assert found.real == [True, True, False, False]
    first = found.pairs[0]
    assert first.difference.value == pytest.approx(0.05, abs=3 * first.difference.error)
    assert first.difference.half_width < 0.015


def test_equal_means_are_called_different_no_more_often_than_said():
    false = [any(compare(side(), side(), "velocity", "m s-1").real) for _ in range(300)]
    assert np.mean(false) < 0.09


def test_the_chance_is_that_of_welchs_test():
    from scipy.stats import ttest_ind

    one, other = belt([1.0, 1.2, 1.1]), belt([1.3, 1.9, 1.4, 1.6])
    (pair,) = compare([one], [other], "velocity", "m s-1").pairs
    assert pair.chance == pytest.approx(ttest_ind(one.values, other.values, equal_var=False).pvalue)


def test_a_single_replicate_knows_what_its_own_window_says():
    one, other = belt(1.0, own=0.01, samples=50), belt(1.1, own=0.02, samples=30)
    (pair,) = compare([one], [other], "velocity", "m s-1").pairs
    assert pair.first.half_width == pytest.approx(0.01) and pair.chance < 1e-6
    (unknown,) = compare([one], [belt(1.1)], "velocity", "m s-1").pairs
    assert np.isnan(unknown.chance) and not any(
        compare([one], [belt(1.1)], "velocity", "m s-1").real
    )


def test_replicates_that_agree_by_accident_still_have_what_each_knows_of_itself():
    """As in the dataset and the line of a run: the larger of the two intervals counts."""
    one, other = belt([1.0, 1.001], own=0.2, samples=20), belt([1.1, 1.101], own=0.2, samples=20)
    (pair,) = compare([one], [other], "velocity", "m s-1").pairs
    assert pair.first.half_width == pytest.approx(0.2 / np.sqrt(2)) and pair.first.freedom == 38
    assert pair.chance > 0.05


def test_equal_values_without_any_error_do_not_differ():
    (pair,) = compare([belt([1.0, 1.0])], [belt([1.0, 1.0])], "velocity", "m s-1").pairs
    assert pair.chance == 1 and pair.difference.value == 0


def test_points_of_one_side_alone_are_counted():
    found = compare(side(), side()[1:], "velocity", "m s-1")
    assert len(found.pairs) == 3 and found.alone == (1, 0)
    with pytest.raises(InputError, match="nothing to compare"):
        compare(side()[:2], side()[2:], "velocity", "m s-1")


def test_points_that_were_run_for_longer_besides_are_told():
    longer = [belt(np.ones(9), frequency=f, replicates=9) for f in (20, 30)]
    found = compare([*side(), *longer], side(), "velocity", "m s-1")
    assert len(found.pairs) == 4 and found.shorter == (2, 0) and found.alone == (0, 0)
    assert [pair.first.freedom for pair in found.pairs] == [8, 8, 7, 7]


def test_what_no_run_knows_is_not_compared(tmp_path):
    path = write_run(tmp_path, parse_point({"system": "chute"}, "test"), failed=[0])
    with pytest.raises(InputError, match="no completed run knows its velocity"):
        read_measured(path, "velocity")


def test_what_follows_from_another_parameter_can_be_ignored():
    varied = [beds(1.0, frequency=f, transient=t) for f, t in ((20, 10), (30, 20))]
    other = [beds(1.0, frequency=f) for f in (20, 30)]
    with pytest.raises(InputError):
        compare(varied, other, "velocity", "m s-1")
    assert len(compare(varied, other, "velocity", "m s-1", ("transient",)).pairs) == 2
    with pytest.raises(InputError, match="differ in nothing but frequency"):
        compare(varied, other, "velocity", "m s-1", ("transient", "frequency"))


def test_run_files_are_read_with_what_each_replicate_knows(tmp_path):
    point = parse_point({"system": "chute", "replicates": 3}, "test")
    path = write_run(tmp_path, point, 0.5, failed=[1])
    (found,), unit = read_measured(path, "velocity")
    assert unit == "m s-1" and found.values.size == 2 and found.parameters["depth"] == 5
    with pytest.raises(InputError, match=r"got 'speed'; allowed: one of .*velocity"):
        read_measured(path, "speed")


def test_a_published_study_is_equal_to_itself():
    from tests.made.processes import ROOT

    measured, unit = read_measured(ROOT / "results" / "published" / "paper_walton", "velocity")
    found = compare(measured, measured, "velocity", unit)
    assert len(found.pairs) > 200 and not any(found.real) and found.alone == (0, 0)
