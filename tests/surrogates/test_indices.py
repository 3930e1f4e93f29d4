"""Indices of functions whose indices are known, of surrogates with errors and of runs."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from sim.surrogates.indices import (
    COLUMNS,
    morris_indices_of_runs,
    sobol_indices,
    sobol_indices_of_runs,
)
from sim.surrogates.predictor import scaled, unscaled
from sim.surrogates.refusals import Refusal
from tests.surrogates.predictors import (
    ISHIGAMI,
    ISHIGAMI_FIRST,
    ISHIGAMI_TOTAL,
    ISHIGAMI_X_Z,
    MadePredictor,
    g_function,
    g_indices,
)

#: Half a unit of the third digit, and some.
DIGITS = 1e-3


def column(table: pd.DataFrame, index: str) -> list[float]:
    return table[table["index"] == index]["value"].tolist()


def test_ishigami_to_three_digits():
    found = sobol_indices(ISHIGAMI, 2**14)
    assert list(found) == list(COLUMNS)
    assert column(found, "first") == pytest.approx(ISHIGAMI_FIRST, abs=DIGITS)
    assert column(found, "total") == pytest.approx(ISHIGAMI_TOTAL, abs=DIGITS)
    assert column(found, "interaction") == pytest.approx([0, ISHIGAMI_X_Z, 0], abs=2 * DIGITS)
    pairs = found[found["index"] == "interaction"][["parameter", "other"]].values.tolist()
    assert pairs == [["x0", "x1"], ["x0", "x2"], ["x1", "x2"]]


def test_the_g_function_to_three_digits():
    found = sobol_indices(MadePredictor(g_function, [[0, 1]] * 4), 2**14)
    first, total = g_indices()
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
        for table in [sobol_indices(replace(ISHIGAMI, error=error), 2**9)]
    ]
    assert widths[0] < widths[1] < widths[2] and widths[2] > 0.1


def test_intervals_hold_the_exact_values():
    exact = [*ISHIGAMI_FIRST, *ISHIGAMI_TOTAL, 0, ISHIGAMI_X_Z, 0]
    held = [
        (table["low"] <= exact) & (exact <= table["high"])
        for blocks in (2**7, 2**8, 2**9)
        for table in [sobol_indices(ISHIGAMI, blocks)]
    ]
    assert np.mean(held) >= 0.85


def test_what_does_not_vary_has_no_indices():
    found = sobol_indices(MadePredictor(lambda x, y: 0 * x + 3.1, [[0, 1]] * 2), 2**5)
    assert found["value"].isna().all()


def saltelli_runs(number: int) -> tuple[np.ndarray, np.ndarray]:
    from SALib.sample import sobol

    problem = {"num_vars": 3, "names": list("xyz"), "bounds": [[0, 1]] * 3}
    shares = sobol.sample(problem, number, calc_second_order=False, seed=3)
    values, _ = ISHIGAMI.predict(scaled(shares, ISHIGAMI.bounds, ISHIGAMI.scales))
    return values, np.full(len(values), 0.1)


def test_runs_of_a_saltelli_design_are_analysed_and_broken_blocks_counted():
    values, errors = saltelli_runs(512)
    whole = sobol_indices_of_runs("xyz", values, errors, "study: s")
    assert column(whole, "first") == pytest.approx(ISHIGAMI_FIRST, abs=0.06)
    assert column(whole, "total") == pytest.approx(ISHIGAMI_TOTAL, abs=0.06)
    assert column(whole, "interaction") == []
    assert whole["noise"].unique() == pytest.approx(0.01 / 13.84, rel=0.05)
    values[[3, 4, 11]] = np.nan
    broken = sobol_indices_of_runs("xyz", values, errors, "study: s")
    assert set(broken["blocks"]) == {510} and set(broken["left_out"]) == {2}
    assert np.isfinite(broken["value"]).all() and not broken["value"].equals(whole["value"])


def test_too_few_whole_blocks_are_no_answer():
    values, errors = saltelli_runs(16)
    values[:: 2 * 5] = np.nan
    assert len(sobol_indices_of_runs("xyz", values, errors, "s"))
    values[5] = np.nan
    with pytest.raises(Refusal) as caught:
        sobol_indices_of_runs("xyz", values, errors, "study: screening")
    message = "study: screening: no indices, as 7 of 16 blocks of 5 points have a value"
    assert str(caught.value).startswith(message)


def morris_runs(function, number=20):
    from SALib.sample import morris

    problem = {"num_vars": 3, "names": list("xyz"), "bounds": [[0, 1]] * 3}
    shares = morris.sample(problem, number, seed=3)
    values = function(*shares.T)
    return shares, values, np.zeros(len(values))


def test_effects_of_a_linear_function_are_its_slopes():
    shares, values, errors = morris_runs(lambda x, y, z: 3 * x - 2 * y + 0 * z)
    found = morris_indices_of_runs("xyz", shares, values, errors, "s")
    assert column(found, "mu") == pytest.approx([3, -2, 0])
    assert column(found, "mu_star") == pytest.approx([3, 2, 0])
    assert column(found, "sigma") == pytest.approx([0, 0, 0], abs=1e-9)
    assert (found["high"] - found["low"]).max() < 1e-9


def test_interactions_show_in_sigma_and_lost_trajectories_are_counted():
    shares, values, errors = morris_runs(lambda x, y, z: x * y + 0 * z)
    values[5] = np.nan
    found = morris_indices_of_runs("xyz", shares, values, errors, "s")
    assert set(found["blocks"]) == {19} and set(found["left_out"]) == {1}
    x, y, z = column(found, "sigma")
    assert min(x, y) > 0.2 and z == pytest.approx(0, abs=1e-9)
    assert (found["low"] <= found["value"]).all() and (found["high"] > found["low"]).any()
