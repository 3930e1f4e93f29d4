"""Comparison of two sides: common points, differences beyond chance, as text and as JSON."""

import numpy as np
import pytest

from sim.__main__ import main
from sim.base.errors import InputError
from sim.dataset.compare import compare, read_side, tabulate
from sim.parameters import complete_values, parse_point
from tests.made.processes import refusal
from tests.made.runs import write_run

RNG = np.random.default_rng(5)


def belt(values, half_width=np.nan, samples=np.nan, **parameters) -> tuple:
    """Return parameters of a bed and what its replicates measure, a row of `tabulate`."""
    point = parse_point({"system": "belt", **parameters}, "test")
    values = np.atleast_1d(np.asarray(values, float))
    return complete_values(point), [
        values,
        *(np.full(values.size, x) for x in (half_width, samples)),
    ]


def beds(mean, **parameters) -> tuple:
    return belt(mean + 0.01 * RNG.normal(size=8), **parameters)


def side(mean=1.0, **parameters) -> list[tuple]:
    return [beds(mean, frequency=f, **parameters) for f in (20, 30, 40, 50)]


def compared(first, second, ignored=()):
    return compare(*(tabulate(rows, "velocity") for rows in (first, second)), ignored)


def test_points_are_paired_by_what_varies_and_what_is_constant_is_compared():
    comparison = compared(side(), side(damping_mass="reduced", seed=7))
    assert [pair.key["frequency"] for pair in comparison.pairs] == [20, 30, 40, 50]
    assert comparison.differing_parameters == {
        "damping_mass": ("own", "reduced")
    } and comparison.unmatched_counts == (0, 0)
    assert comparison.is_real == [False] * 4


@pytest.mark.long
def test_equal_means_are_called_different_no_more_often_than_said():
    false = [any(compared(side(), side()).is_real) for _ in range(300)]
    assert np.mean(false) < 0.09


def test_the_chance_is_that_of_welchs_test():
    from scipy.stats import ttest_ind

    one, other = belt([1.0, 1.2, 1.1]), belt([1.3, 1.9, 1.4, 1.6])
    (pair,) = compared([one], [other]).pairs
    assert pair.chance == pytest.approx(ttest_ind(one[1][0], other[1][0], equal_var=False).pvalue)


def test_a_single_replicate_knows_what_its_own_window_says():
    one, other = belt(1.0, half_width=0.01, samples=50), belt(1.1, half_width=0.02, samples=30)
    (pair,) = compared([one], [other]).pairs
    assert pair.first.half_width == pytest.approx(0.01) and pair.chance < 1e-6
    (unknown,) = compared([one], [belt(1.1)]).pairs
    assert np.isnan(unknown.chance) and not any(compared([one], [belt(1.1)]).is_real)


def test_points_of_one_side_alone_are_counted():
    comparison = compared(side(), side()[1:])
    assert len(comparison.pairs) == 3 and comparison.unmatched_counts == (1, 0)
    chute = complete_values(parse_point({"system": "chute"}, "test"))
    both = compared([*side(), (chute, belt(1.0)[1])], side())
    assert len(both.pairs) == 4 and both.unmatched_counts == (1, 0)
    with pytest.raises(InputError, match="nothing to compare"):
        compared(side()[:2], side()[2:])


def test_points_that_were_run_for_longer_besides_are_told():
    longer = [belt(np.ones(9), frequency=f, replicates=9) for f in (20, 30)]
    comparison = compared([*side(), *longer], side())
    assert (
        len(comparison.pairs) == 4
        and comparison.shorter_counts == (2, 0)
        and comparison.unmatched_counts == (0, 0)
    )
    assert [pair.first.freedom for pair in comparison.pairs] == [8, 8, 7, 7]


def test_what_follows_from_another_parameter_can_be_ignored():
    varied = [beds(1.0, frequency=f, transient=t) for f, t in ((20, 10), (30, 20))]
    other = [beds(1.0, frequency=f) for f in (20, 30)]
    with pytest.raises(InputError):
        compared(varied, other)
    assert len(compared(varied, other, ("transient",)).pairs) == 2
    with pytest.raises(InputError, match="differ in nothing but frequency"):
        compared(varied, other, ("transient", "frequency"))


def test_run_files_are_read_with_what_each_replicate_knows(tmp_path):
    parameters = parse_point({"system": "chute", "replicates": 3}, "test")
    path = write_run(tmp_path, parameters, 0.5, failed=[1])
    table, unit = read_side(path, "velocity")
    (point,) = table.to_dict("records")
    assert unit == "m s-1" and point["_replicates"] == 2 and point["depth"] == 5
    with pytest.raises(InputError, match=r"got 'speed'; did you mean velocity"):
        read_side(path, "speed")


@pytest.fixture
def runs(tmp_path):
    """Two run files of other friction."""
    points = [
        parse_point({"system": "chute", "replicates": 3, "friction": mu}, "test")
        for mu in (0.4, 0.5)
    ]
    paths = []
    for number, (point, velocity) in enumerate(zip(points, (0.5, 0.4), strict=True)):
        (folder := tmp_path / str(number)).mkdir()
        paths.append(str(write_run(folder, point, velocity)))
    return paths


def test_two_runs_are_told_with_intervals_and_what_is_different(runs, capsys):
    assert main(["compare", *runs]) == 0
    out = capsys.readouterr().out
    assert "friction: A 0.4, B 0.5" in out and "velocity (m s-1), with 95 % intervals" in out
    assert "of 1 point" in out and "±" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--ignore", "frction"], "--ignore: got 'frction'"),
        (["--of", "speed"], "got 'speed'; did you mean velocity"),
    ],
)
def test_what_is_not_known_is_refused_in_one_line(words, message, runs, capsys):
    assert message in refusal(capsys, "compare", *runs, *words)
