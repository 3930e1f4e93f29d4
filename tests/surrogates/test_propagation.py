"""Propagation: closed forms, intervals that hold the truth, noise, and where there is no number."""

import numpy as np
import pytest
from scipy.stats import expon, lognorm, norm

from sim.study.design import Axis
from sim.surrogates.answers import Refusal, caveats_of_indices
from sim.surrogates.indices import DesignRuns
from sim.surrogates.propagation import _exceedance, spread_of_runs, spread_of_surrogate
from tests.coverage import propagation
from tests.coverage.rows import coverage
from tests.made.surrogates import AXES, made_surrogate, smooth

LEVELS, NONE = (0.25, 0.5, 0.75), ()


def runs_of(values, variances=0.0) -> DesignRuns:
    values = np.asarray(values, float)
    known = np.broadcast_to(np.asarray(variances, float), values.shape)
    return DesignRuns(("x",), values, known, np.arange(len(values)))


def rows_of(table):
    """Return value, low and high by what they are of, as ``quantile 0.5``."""
    names = (table["index"] + " " + table["parameter"]).str.strip()
    return dict(zip(names, table[["value", "low", "high"]].to_numpy(), strict=True))


def test_probabilities_are_those_of_clopper_and_pearson():
    # Their tables of 1934, Biometrika 26, 404.
    assert _exceedance(0, 10) == pytest.approx((0.0, 0.0, 0.3085), abs=1e-4)
    assert _exceedance(5, 10) == pytest.approx((0.5, 0.1871, 0.8129), abs=1e-4)
    assert _exceedance(10, 10) == pytest.approx((1.0, 0.6915, 1.0), abs=1e-4)


def test_many_normal_runs_have_the_intervals_of_textbooks():
    count = 40_000
    values = norm(5, 2).ppf((np.arange(count) + 0.5) / count)
    rows = rows_of(spread_of_runs(runs_of(values), (0.5, 0.975), (5.0, 9.0)))
    half = 1.96 * 2 / np.sqrt(count)
    assert rows["mean"] == pytest.approx([5, 5 - half, 5 + half], abs=1e-3)
    assert rows["deviation"][0] == pytest.approx(2, rel=1e-3)
    assert np.ptp(rows["deviation"][1:]) == pytest.approx(2 * half / np.sqrt(2), rel=0.02)
    median = 2 * half * np.sqrt(np.pi / 2)
    assert np.ptp(rows["quantile 0.5"][1:]) == pytest.approx(median, rel=0.03)
    assert rows["quantile 0.975"][0] == pytest.approx(5 + 2 * 1.95996, abs=1e-2)
    assert rows["exceedance 9"] == pytest.approx([0.02275, 0.0213, 0.0243], abs=2e-4)


@pytest.mark.parametrize("spread", [norm(3), expon(), lognorm(0.5)], ids=["n", "exp", "log"])
def test_intervals_of_runs_hold_the_truth(spread):
    rng, held, sets = np.random.default_rng(1), [], 60
    truth = [spread.mean(), spread.std(), *spread.ppf(LEVELS), spread.sf(3.5)]
    for _ in range(sets):
        table = spread_of_runs(runs_of(spread.rvs(40, random_state=rng)), LEVELS, (3.5,))
        held.append((table["low"] <= truth) & (truth <= table["high"]))
    # Of 60 sets, 52 or fewer hold once in 100 times where 95 % do; the deviations of skewed values
    # hold less often.
    shares = np.mean(held, axis=0)
    assert shares[1] > 0.83 and (np.delete(shares, 1) > 0.87).all()


def test_a_long_tail_is_told():
    tailed = lognorm(1.0).ppf((np.arange(200) + 0.5) / 200)
    (text,) = caveats_of_indices(spread_of_runs(runs_of(tailed), LEVELS, NONE))
    assert text.startswith("deviation: a long tail")


def test_too_few_runs_for_a_quantile_have_no_number_but_the_others_stand():
    table = spread_of_runs(runs_of(np.linspace(0, 1, 72)), (0.04, 0.05, 0.95, 0.999), NONE)
    by_level = table.set_index("parameter")
    assert np.isfinite(by_level.loc[["0.05", "0.95"], ["value", "low", "high"]]).all(axis=None)
    assert by_level.loc[["0.04", "0.999"], ["value", "low", "high"]].isna().all(axis=None)
    assert by_level.loc["0.04", "doubt"] == "without a value, which takes 91 runs or more"
    assert "quantile 0.999: without a value, which takes 3,688 runs or more" in "; ".join(
        caveats_of_indices(table)
    )


def test_the_noise_of_the_runs_is_taken_off_and_told():
    rng, held = np.random.default_rng(2), []
    for _ in range(60):
        true, noise = rng.normal(0, 2, 64), rng.normal(0, 1, 64)
        rows = rows_of(spread_of_runs(runs_of(true + noise, 1.0), (0.25, 0.75), NONE))
        ends = np.array(list(rows.values()))[1:]
        held.append((ends[:, 1] <= TRUTH) & (ends[:, 2] >= TRUTH))
    assert np.mean(held, axis=0).min() > 0.88
    told = caveats_of_indices(spread_of_runs(runs_of(2 * TRUTH_64, 1.0), LEVELS, NONE))
    assert told == ("the noise of the runs is 25 % of their variance",)
    unknown = caveats_of_indices(spread_of_runs(runs_of(true, np.nan), LEVELS, NONE))
    assert unknown == (
        "the noise of the runs is not known, as points have one replicate, and counts as spread",
    )
    with pytest.raises(Refusal, match="no spread, as the noise of the runs is 5"):
        spread_of_runs(runs_of(true, 0.55 * true.var(ddof=1)), LEVELS, NONE)


TRUTH = (2.0, *norm(0, 2).ppf([0.25, 0.75]))
TRUTH_64 = norm().ppf((np.arange(64) + 0.5) / 64)


def test_runs_without_a_value_are_told_and_too_many_are_no_answer():
    values = np.where(np.arange(40) < 4, np.nan, np.linspace(1, 2, 40))
    table = spread_of_runs(runs_of(values), LEVELS, NONE)
    text = "4 of 40 runs have no value that counts, so that it is of the others"
    assert caveats_of_indices(table) == (text,)
    for few in (values[:11], np.where(np.arange(40) < 21, np.nan, values)):
        with pytest.raises(Refusal, match="no spread, as "):
            spread_of_runs(runs_of(few), LEVELS, NONE)


def test_a_constant_has_no_deviation():
    rows = rows_of(spread_of_runs(runs_of(np.full(100, 2.5)), LEVELS, (2.0, 3.0)))
    assert rows["deviation"].tolist() == [0, 0, 0] and rows["mean"].tolist() == [2.5] * 3
    assert rows["exceedance 2"][0] == 1 and rows["exceedance 3"][0] == 0


def linear(x):
    return 1 + 2 * x[:, 0] + 3 * x[:, 1]


def of_surrogate(function, axes=AXES[:2], where=(), exceeds=(), **options):
    surrogate = made_surrogate(function, **options)
    table = spread_of_surrogate(surrogate, axes, where, (0.5,), exceeds, draws=2**9)
    return rows_of(table)


def test_a_surrogate_of_a_line_has_the_closed_form():
    rows = of_surrogate(linear, exceeds=(1.0, 7.0))
    assert rows["mean"][0] == pytest.approx(3.5, abs=1e-3)
    assert rows["deviation"][0] == pytest.approx(np.sqrt(13 / 12), rel=1e-3)
    assert rows["quantile 0.5"][0] == pytest.approx(3.5, abs=0.02)
    assert rows["exceedance 1"][0] == 1 and rows["exceedance 7"][0] == 0
    assert 0 < rows["exceedance 7"][2] < 1e-3


def test_parameters_are_spread_as_they_are_asked_for():
    normal = (Axis("friction", 0.2, 0.8, normal=(0.5, 0.06)), AXES[1])
    rows = of_surrogate(linear, normal)
    assert rows["deviation"][0] == pytest.approx(np.sqrt(4 * 0.1**2 + 9 / 12), rel=5e-3)
    lower = of_surrogate(linear, where=("friction < 0.5",))
    assert lower["mean"][0] == pytest.approx(3.0, abs=0.01)


def test_the_error_of_a_surrogate_widens_its_intervals():
    exact, noisy = (of_surrogate(smooth, error=error) for error in (0.0, 0.15))
    for name in ("mean", "deviation", "quantile 0.5"):
        assert np.ptp(noisy[name][1:]) > 2 * np.ptp(exact[name][1:])


def test_a_surrogate_that_has_not_learned_has_no_spread():
    rough = np.random.default_rng(1).normal(5, 1, 24)
    with pytest.raises(Refusal, match="no spread, as the points of surrogate speed do not tell"):
        of_surrogate(lambda x: rough)
    with pytest.raises(Refusal, match="no spread, as surrogate speed is of flows that are"):
        far = (Axis("friction", 0.2, 0.8), Axis("depth", 30.0, 40.0))
        of_surrogate(linear, far)


def test_intervals_of_the_cantilever_hold_what_brute_force_says():
    _, held = coverage(propagation.questions("cantilever, 32 runs", designs=6))
    assert len(held) == 6 and np.mean(held) >= 0.85
