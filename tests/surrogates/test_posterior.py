"""Posteriors: they hold the truth as often as they promise, and say so where nothing fits."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from sim.surrogates import posterior
from sim.surrogates.answers import caveats_of_posterior
from sim.surrogates.likelihood import Calibration
from sim.surrogates.posterior import DISCREPANCY, calibrate, summarize
from sim.surrogates.storage import load_posterior, outcome_sentences, save_posterior
from tests.surrogates.predictors import RANGES, MadePredictor, made_measurements


@pytest.fixture
def shorter(monkeypatch) -> None:
    """Let chains be shorter, where a test asks for no small interval."""
    monkeypatch.setattr(posterior, "_STEPS", 400)
    monkeypatch.setattr(posterior, "LONG_ENOUGH", 20)


@pytest.fixture(scope="module")
def groups():
    return calibrate(made_measurements(1)[1])


def test_a_posterior_is_what_arviz_reads(groups, tmp_path):
    save_posterior("made", groups, [], tmp_path / "made.nc")
    found = load_posterior(tmp_path / "made.nc")
    assert list(found) == list(groups)
    for name, one in groups.items():
        xr.testing.assert_equal(found[name], one)
    drawn = found["posterior"]
    assert drawn["friction"].dims == ("chain", "draw") and set(drawn) == {*RANGES, DISCREPANCY}
    for name, (low, high) in RANGES.items():
        assert drawn[name].min() >= low and drawn[name].max() <= high
    assert found["posterior_predictive"]["velocity"].dims == ("chain", "draw", "measurement")
    assert outcome_sentences(found) == outcome_sentences(groups)


def test_chains_are_long_enough_or_say_that_they_are_not(groups, monkeypatch):
    about = groups["observed_data"].attrs
    assert about["outcome"] == "converged"
    assert about["steps"] >= posterior.LONG_ENOUGH * about["autocorrelation"]
    for name in ("MOST_STEPS", "_STEPS"):
        monkeypatch.setattr(posterior, name, 100)
    short = calibrate(made_measurements(1)[1])["observed_data"].attrs
    assert short["outcome"] == "not converged"
    (text,) = caveats_of_posterior(short)
    assert text.startswith("its chains are ") and text.endswith("too short for its intervals")


def test_what_no_parameters_give_is_no_narrow_posterior(shorter):
    groups = calibrate(made_measurements(1, shift=3.0)[1])
    assert "posterior" not in groups and groups["observed_data"].attrs["outcome"] == "no fit"
    (sentence,) = outcome_sentences(groups)
    assert sentence.startswith("No parameters in the ranges fit: measurements as far from the")


#: A parameter that sets the slope, and one without effect.
LINE = MadePredictor(
    lambda slope, idle, depth: slope * depth + 0 * idle,
    [(0, 2), (0, 1), (1, 9)],
    parameters=("slope", "idle", "depth"),
)


def line(depths=(2.0, 3.0, 4.0), scales=("linear",) * 3, bounds=None, **options) -> Calibration:
    depths = np.array(depths)
    made = replace(LINE, scales=scales, bounds=LINE.bounds if bounds is None else np.array(bounds))
    ranges = {name: tuple(made.bounds[k]) for k, name in enumerate(("slope", "idle"))}
    errors = np.full(len(depths), 0.05)
    values = 1.1 * depths
    return Calibration(made, ranges, {"depth": depths}, values, errors, "velocity", **options)


def test_data_inform_the_parameter_that_matters_alone_and_more_where_it_shows_most(shorter):
    groups = calibrate(line())
    xr.testing.assert_identical(calibrate(line())["posterior"], groups["posterior"])
    rows = summarize(groups).set_index("parameter")
    assert rows["informed"].to_dict() == {"slope": True, "idle": False}
    assert abs(rows["median"]["slope"] - 1.1) < 0.02 < rows["high"]["slope"] - 1.1 + 0.02
    assert rows["share"]["idle"] == pytest.approx(1, abs=0.1)
    assert outcome_sentences(groups)[1].startswith("idle is not determined (0.0")
    candidates = groups["predictions_constant_data"]
    best = candidates.isel(candidate=int(np.argmax(candidates["narrowing"].values)))
    assert best["depth"] == 4.0 and 0 < best["narrowing"] < 1
    assert candidates["depth"].min() == 2 and candidates["depth"].max() == 4


def test_an_uncertain_surrogate_gives_wider_posteriors(shorter):
    made = line()
    unsure = replace(made, predictor=replace(made.predictor, error=0.3))
    narrow, wide = (
        summarize(calibrate(one)).set_index("parameter")["share"]["slope"] for one in (made, unsure)
    )
    assert wide > 2 * narrow


def test_parameters_are_even_in_their_scale(shorter):
    bounds = [(0.01, 100), (0, 1), (1, 9)]
    made = line(depths=(2.0,), scales=("log", "linear", "linear"), bounds=bounds)
    vague = replace(made, errors=np.array([1e4]))
    slope = calibrate(vague)["posterior"]["slope"]
    assert np.log10(slope).mean() == pytest.approx(0, abs=0.2)


def test_measurements_without_conditions_are_calibrated_too(shorter):
    made = MadePredictor(lambda slope: slope, [(0, 2)], parameters=("slope",))
    values, errors = np.array([1.0, 1.1, 1.05]), np.full(3, 0.1)
    groups = calibrate(Calibration(made, {"slope": (0.0, 2.0)}, {}, values, errors, "velocity"))
    (row,) = summarize(groups).itertuples()
    assert row.low < 1.05 < row.high and row.informed
    assert groups["predictions_constant_data"].sizes["candidate"] == 1


def test_a_combination_that_is_known_is_told():
    rng = np.random.default_rng(1)
    first, noise = rng.random((2, 1, 4000))
    for sign, words in (
        (1, "larger idle (correlation 0.9"),
        (-1, "smaller idle (correlation -0.9"),
    ):
        draws = {"slope": first, "idle": 0.5 + sign * 0.4 * (first - 0.5) + 0.05 * noise}
        assert f"a larger slope goes with a {words}" in outcome_sentences(groups_of(draws))[-1]
    assert len(outcome_sentences(groups_of({"slope": first, "idle": noise}))) == 2


def groups_of(draws, uncounted=0.0, regime="", outcome="converged"):
    attributes = {
        "outcome": outcome,
        "probability": 0.5,
        "uncounted": uncounted,
        "uncounted_regime": regime,
        "parameters": list(draws),
        "scales": ["linear"] * len(draws),
        "low": np.zeros(len(draws)),
        "high": np.ones(len(draws)),
    }
    columns = {name: (("chain", "draw"), one) for name, one in draws.items()}
    return {"posterior": xr.Dataset(columns), "observed_data": xr.Dataset(attrs=attributes)}


def test_the_share_of_a_posterior_where_nothing_flows_is_told():
    draws = {"slope": np.random.default_rng(1).random((1, 100))}
    about = groups_of(draws, 0.123, "arrested")["observed_data"].attrs
    about |= {"steps": 100, "autocorrelation": 1.0}
    (told,) = caveats_of_posterior(about)
    assert told == "12 % of the posterior lies where the flow is arrested"
    assert caveats_of_posterior(about | {"uncounted": 0.001}) == ()
    (none,) = outcome_sentences(groups_of(draws, 0.998, "arrested", "no fit"))
    assert none == (
        "No parameters in the ranges fit: 99.8 % of those that come nearest lie where the flow is "
        "arrested."
    )


def test_a_model_that_lacks_nothing_has_no_discrepancy(shorter):
    draws = np.array([[0.55, 0.5]])
    made = replace(line(), has_discrepancy=False)
    assert not made.discrepancy(draws).any() and line().discrepancy(np.ones((1, 3))) == 0.05
    assert made.log_probability(draws) == line().log_probability(np.array([[0.55, 0.5, 0.0]]))
    assert set(calibrate(made)["posterior"]) == {"slope", "idle"}
