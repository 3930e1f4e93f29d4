"""Indices of functions whose indices are known, of surrogates with errors and of runs."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from sim.surrogates.answers import Refusal, caveats_of_indices
from sim.surrogates.indices import COLUMNS, indices_of_surrogate, sobol_indices
from sim.surrogates.predictor import scaled, unscaled
from sim.surrogates.surrogate import Surrogate
from tests.made.surrogates import design, made_surrogate
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

#: Blocks where digits do not count.
BLOCKS = 2**5


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
    exact = [*ISHIGAMI_FIRST, *ISHIGAMI_TOTAL, sum(ISHIGAMI_FIRST), 0, ISHIGAMI_X_Z, 0]
    held = [
        (table["low"] <= exact) & (exact <= table["high"])
        for blocks in (2**7, 2**8, 2**9)
        for table in [sobol_indices(ISHIGAMI, blocks)]
    ]
    assert np.mean(held) >= 0.85


def test_what_does_not_vary_has_no_indices():
    surrogate = made_surrogate()
    for spread in (0.0, 4e-16, 1e-13):
        mean = 3.1 + spread * surrogate.sample["friction"]
        still = replace(surrogate, sample=surrogate.sample.assign(mean=mean))
        with pytest.raises(Refusal, match="asked: no indices, as the observable does not vary"):
            indices_of_surrogate(still, "asked")


def flows_beyond(edge: float) -> Surrogate:
    """Return a surrogate of flows that are steady beyond a share of the range of friction."""
    regime = np.where(design(32, 2)[:, 0] < edge, "arrested", "steady")
    return made_surrogate(count=32, regime=regime)


def test_the_share_of_the_ranges_without_such_a_flow_is_told():
    table = indices_of_surrogate(flows_beyond(0.4), "asked", blocks=BLOCKS)
    assert table["absent"].unique() == pytest.approx(0.4, abs=0.05)
    assert "of a regime that counts is likely" in caveats_of_indices(table)[0]


def test_most_of_the_ranges_without_such_a_flow_is_no_answer():
    with pytest.raises(Refusal, match=r"undetermined, and in [67]. % of the ranges no such"):
        indices_of_surrogate(flows_beyond(0.7), "asked")
