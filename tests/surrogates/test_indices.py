"""Indices of functions whose indices are known, of surrogates with errors, and of made-up runs."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from sim.study.load import parse_study
from sim.surrogates import answers, storage
from sim.surrogates.answers import Refusal, caveats_of_indices
from sim.surrogates.indices import (
    COLUMNS,
    DesignRuns,
    indices_of_surrogate,
    morris_indices_of_runs,
    sobol_indices,
    sobol_indices_of_runs,
)
from sim.surrogates.inquiries import places_of
from sim.surrogates.sample import scaled, unscaled
from sim.surrogates.surrogate import Surrogate
from sim.verify.exact import g_function, g_indices, ishigami
from tests.figures.drawing import picture, table
from tests.made.answers import picture_data
from tests.made.surrogates import design, made_runs, made_surrogate
from tests.surrogates.predictors import (
    ISHIGAMI,
    ISHIGAMI_FIRST,
    ISHIGAMI_TOTAL,
    ISHIGAMI_X_Z,
    MadePredictor,
)

#: A unit of the third digit, and some.
DIGITS = 1.5e-3

#: Blocks where digits do not count.
BLOCKS = 2**5


def column(table: pd.DataFrame, index: str) -> list[float]:
    return table[table["index"] == index]["value"].tolist()


def test_indices_are_those_that_are_known():
    found = sobol_indices(ISHIGAMI, 2**13)
    assert list(found) == list(COLUMNS)
    assert column(found, "first") == pytest.approx(ISHIGAMI_FIRST, abs=DIGITS)
    assert column(found, "total") == pytest.approx(ISHIGAMI_TOTAL, abs=DIGITS)
    assert column(found, "interaction") == pytest.approx([0, ISHIGAMI_X_Z, 0], abs=2 * DIGITS)
    pairs = found[found["index"] == "interaction"][["parameter", "other"]].values.tolist()
    assert pairs == [["x0", "x1"], ["x0", "x2"], ["x1", "x2"]]
    found = sobol_indices(
        MadePredictor(lambda *x: g_function(np.stack(x, axis=1)), [[0, 1]] * 4), 2**13
    )
    first, total = g_indices(4)
    assert column(found, "first") == pytest.approx(first, abs=DIGITS)
    assert column(found, "total") == pytest.approx(total, abs=DIGITS)


def test_values_are_spread_evenly_in_the_scale_of_a_parameter():
    steep = MadePredictor(
        lambda x, y: np.log10(x) + y, [[1, 100], [0, 2]], scales=("log", "linear")
    )
    assert column(sobol_indices(steep), "first") == pytest.approx([0.5, 0.5], abs=2 * DIGITS)
    x = scaled(np.array([[0.5, 0.5]]), steep.bounds, steep.scales)
    assert x.tolist() == [[pytest.approx(10), 1]]
    assert unscaled(x, steep.bounds, steep.scales).tolist() == [[pytest.approx(0.5), 0.5]]


def test_the_error_of_a_surrogate_widens_the_intervals():
    widths = [
        (table["high"] - table["low"]).max()
        for error in (0.0, 0.5, 2.0)
        for table in [sobol_indices(replace(ISHIGAMI, error=error), 2**7)]
    ]
    assert widths[0] < widths[1] < widths[2] and widths[2] > 0.1


@pytest.mark.parametrize("kind", ["surrogate", "saltelli", "morris"])
@pytest.mark.parametrize("spread", [0.0, 1e-13])
def test_a_spread_of_rounding_is_no_answer(kind, spread):
    with pytest.raises(Refusal, match="no indices, as the observable does not vary"):
        if kind == "surrogate":
            made = made_surrogate()
            mean = 3.1 + spread * made.sample["friction"]
            indices_of_surrogate(replace(made, sample=made.sample.assign(mean=mean)))
        analyse(kind, *made_runs(lambda x: 3.1 + spread * x[:, 0], kind, 16))


def flows_beyond(edge: float) -> Surrogate:
    """Return a surrogate of flows that are steady beyond a share of the range of friction."""
    regime = np.where(design(32, 2)[:, 0] < edge, "arrested", "steady")
    return made_surrogate(count=32, regime=regime)


def test_the_share_of_the_ranges_without_such_a_flow_is_told_and_most_is_no_answer():
    table = indices_of_surrogate(flows_beyond(0.4), blocks=BLOCKS)
    assert table["absent"].unique() == pytest.approx(0.4, abs=0.05)
    assert "of a regime that counts is likely" in caveats_of_indices(table)[0]
    with pytest.raises(Refusal, match=r"undetermined, and in [67]. % of the ranges no such"):
        indices_of_surrogate(flows_beyond(0.7))


NUMBERS = [True] * 3


def plain(shares):
    """A function of the first two parameters, without interaction."""
    return 2 + shares[:, 0] - 0.5 * shares[:, 1]


def analyse(kind, runs, *places):
    if kind == "morris":
        return morris_indices_of_runs(runs, *places, NUMBERS)
    return sobol_indices_of_runs(runs)


def screening(function, **options):
    return analyse("morris", *made_runs(function, "morris", 20, **options))


def with_values(runs, rows, value):
    values = runs.values.copy()
    values[rows] = value
    return replace(runs, values=values)


def test_runs_of_a_saltelli_design_are_analysed_and_broken_blocks_counted():
    runs, *_ = made_runs(ishigami, "saltelli", 512)
    whole = sobol_indices_of_runs(runs)
    assert list(whole) == list(COLUMNS)
    assert column(whole, "first") == pytest.approx(ISHIGAMI_FIRST, abs=0.06)
    assert column(whole, "total") == pytest.approx(ISHIGAMI_TOTAL, abs=0.06)
    assert column(whole, "sum") == pytest.approx([sum(column(whole, "first"))])
    assert (whole["noise"] == 0).all() and not caveats_of_indices(whole)
    broken = sobol_indices_of_runs(with_values(runs, [3, 4, 11], np.nan))
    assert set(broken["blocks"]) == {510} and set(broken["left_out"]) == {2}
    assert np.isfinite(broken["value"]).all() and not broken["value"].equals(whole["value"])


def test_noise_is_taken_off_and_widens():
    """A parameter without effect has a total index of 0, not that of the noise."""
    totals, held, widths = [], [], {0.0: [], 0.1: []}
    exact = np.array([0.8, 0.2, 0.0] * 2 + [1.0])
    for seed in range(10):
        for noise in widths:
            runs, *_ = made_runs(plain, "saltelli", 64, seed=seed, noise=noise)
            found = sobol_indices_of_runs(runs)
            widths[noise].append(found["high"] - found["low"])
        totals.append(column(found, "total")[2])
        held.append((found["low"] < exact) & (exact < found["high"]))
        assert found["noise"][0] == pytest.approx(0.2, abs=0.07)
        assert "the noise of the runs is" in caveats_of_indices(found)[-1]
    assert abs(np.mean(totals)) < 0.05 and np.mean(held) > 0.9
    assert np.mean(widths[0.1]) > 1.2 * np.mean(widths[0.0])


def test_noise_of_points_with_one_replicate_is_not_known_and_told():
    runs, *_ = made_runs(plain, "saltelli", 16, noise=0.05, replicates=1)
    found = sobol_indices_of_runs(runs)
    assert found["noise"].isna().all() and "is not known" in caveats_of_indices(found)[-1]
    assert column(found, "total")[2] > 0
    some = np.where(np.arange(len(runs.values)) % 3, np.nan, 1e-6)
    assert sobol_indices_of_runs(replace(runs, variances=some))["noise"].notna().all()


def test_runs_of_noise_alone_are_no_answer():
    runs, *_ = made_runs(plain, "saltelli", 16, noise=0.5)
    with pytest.raises(Refusal, match=r"no indices, as the noise of the runs is \d+ %"):
        sobol_indices_of_runs(runs)


def test_an_index_outside_0_to_1_by_more_than_its_interval_has_a_word():
    found = []
    for seed in range(40):
        table = sobol_indices_of_runs(made_runs(ishigami, "saltelli", 8, seed=seed)[0])
        outside = table[(table["high"] < 0) | (table["low"] > 1)]
        assert (table["doubt"] != "").sum() == len(outside)
        found += caveats_of_indices(outside) if len(outside) else []
    *found, few = found
    assert found and all("outside 0 to 1 by more than its interval" in text for text in found)
    assert few == "8 blocks may miss an effect in a small part of the ranges"


def test_too_few_whole_blocks_are_no_answer():
    runs, *_ = made_runs(ishigami, "saltelli", 16)
    runs = with_values(runs, slice(0, None, 10), np.nan)
    assert len(sobol_indices_of_runs(runs))
    with pytest.raises(Refusal) as caught:
        sobol_indices_of_runs(with_values(runs, 5, np.nan))
    message = "no indices, as 7 of 16 blocks of 5 points have a value"
    assert str(caught.value).startswith(message)


def test_equal_effects_have_no_interval(tmp_path):
    """Nobody knows how far others may be off, but where the parameter changes no bit."""
    found = screening(lambda x: 3 * x[:, 0] - 2 * x[:, 1])
    assert column(found, "mu") == pytest.approx([3, -2, 0])
    assert column(found, "mu_star") == pytest.approx([3, 2, 0])
    assert column(found, "sigma") == pytest.approx([0, 0, 0], abs=1e-9)
    has_none = found["parameter"].isin(["x", "y"])
    assert (found["low"].isna() == has_none).all() and (found["high"].isna() == has_none).all()
    assert (found["doubt"].str.contains("no interval") == has_none).all()
    named = found.replace({"x": "friction", "y": "restitution", "z": "angle"})
    answers.save_table(named, tmp_path / "sensitivity" / "screened.csv")
    line = storage.table_line(tmp_path / "sensitivity" / "screened.csv")
    assert line == "mean size of the effect of friction 3, restitution 2, angle 0 (0 to 0)"
    data = picture_data(tmp_path, "screening", "sensitivity/screened.csv")
    assert len(table(data)) == 9 and picture(data).axes[0].get_xlim()[1] > 3


def test_places_are_those_of_the_values_of_a_design():
    over = {
        "angle": [14, 18],
        "steps_per_collision": [21, 23],
        "stiffness": {"between": [100, 10000], "scale": "log"},
        "law": {"choices": ["walton_braun", "hertz"]},
    }
    series = {"name": "wide", "system": "chute"}
    series["design"] = {"kind": "morris", "points": 50, "over": over}
    made = parse_study({"study": "s", "series": [series]}, "s.yaml", None).designs["wide"]
    places, shares, names = places_of(made), made.shares(50), made.names
    at = dict(zip(names, places.T, strict=True))
    assert set(at["steps_per_collision"]) == {0, 0.5, 1} and set(at["law"]) == {0, 1}
    for name in ("angle", "stiffness"):
        assert at[name] == pytest.approx(shares[:, names.index(name)], abs=1e-5)
    values = np.array([float(row["steps_per_collision"]) for row in made.rows(50)])
    runs = DesignRuns(names, values, 0 * values, np.arange(50))
    found = morris_indices_of_runs(runs, shares, places, [name != "law" for name in names])
    effects = [2 * (name == "steps_per_collision") for name in names]
    assert column(found, "mu_star") == pytest.approx(effects)


def test_a_parameter_that_never_changes_has_no_effect_to_tell():
    with pytest.raises(Refusal, match="no effects, as x has the same value"):
        screening(plain, places=lambda x: x * [0, 1, 1])


def test_interactions_show_in_sigma_and_lost_trajectories_are_counted():
    runs, *rest = made_runs(lambda x: x[:, 0] * x[:, 1], "morris", 20)
    found = morris_indices_of_runs(with_values(runs, 5, np.nan), *rest, NUMBERS)
    assert set(found["blocks"]) == {19} and set(found["left_out"]) == {1}
    x, y, z = column(found, "sigma")
    assert min(x, y) > 0.2 and z == pytest.approx(0, abs=1e-9)
    assert (found["low"] <= found["value"]).all() and (found["high"] > found["low"]).any()
