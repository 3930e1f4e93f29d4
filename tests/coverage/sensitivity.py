"""How often the intervals of sensitivities hold the truth: a row for each kind of question.

`python -m tests.coverage.sensitivity` prints the table of docs/validation.md. Each design is asked
as a study would: a surrogate is fitted to values of replicates, or these are analysed as they are.
"""

from collections.abc import Iterator
from functools import lru_cache, partial

import numpy as np
import pandas as pd

from sim.surrogates.indices import (
    indices_of_surrogate,
    morris_indices_of_runs,
    sobol_indices,
    sobol_indices_of_runs,
)
from sim.surrogates.inquiries import require_small_error
from sim.verify.exact import g_function, ishigami
from tests.coverage.rows import HEADINGS, Question, cells, fitted, print_table, unit_axes
from tests.made.surrogates import Function, design, made_runs, smooth
from tests.surrogates.predictors import MadePredictor

#: Designs of a case; blocks of a surrogate, and of a truth.
DESIGNS, BLOCKS, TRUE_BLOCKS = 40, 2**7, 2**12

#: Digits of a truth.
DIGITS = 1e-3


def flat(x):
    """A function of two parameters of three."""
    return 0.5 + np.exp(x[:, 0]) * (0.3 + 0.5 * x[:, 1] ** 2)


def eight(x):
    return 1 + x[:, 0] + x[:, 1] ** 2 + 0.5 * np.sin(3 * x[:, 2]) * x[:, 3] + x[:, 4:].sum(axis=1)


def step(height: float, x: np.ndarray) -> np.ndarray:
    return smooth(x) * (1 + height * (x[:, 0] + 0.5 * x[:, 1] > 0.7))


#: Function, parameters, points, noise of a replicate, and share of the first range without a flow.
SURROGATES = {
    "smooth, 2 parameters, 16 points": (smooth, 2, 16, 0.05, 0.0),
    "smooth, 3 parameters, 16 points": (smooth, 3, 16, 0.05, 0.0),
    "smooth, 8 parameters, 64 points": (eight, 8, 64, 0.05, 0.0),
    "Ishigami, 64 points": (ishigami, 3, 64, 0.0, 0.0),
    "Ishigami, 128 points": (ishigami, 3, 128, 0.0, 0.0),
    "Sobol' G, 64 points": (g_function, 4, 64, 0.0, 0.0),
    "noise 1 %, 32 points": (smooth, 3, 32, 0.01, 0.0),
    "noise 20 %, 32 points": (smooth, 3, 32, 0.2, 0.0),
    "noise 30 %, 32 points": (smooth, 3, 32, 0.3, 0.0),
    "step of 30 %, 32 points": (partial(step, 0.3), 3, 32, 0.01, 0.0),
    "step of 100 %, 32 points": (partial(step, 1.0), 3, 32, 0.01, 0.0),
    "regime that ends at 30 % of a range, 32 points": (smooth, 3, 32, 0.02, 0.3),
    "regime that ends at 70 % of a range, 32 points": (smooth, 3, 32, 0.02, 0.7),
    "4 of 48 points": (eight, 5, 48, 0.02, 11 / 12),
}

#: Kind, blocks and noise of a replicate, relative to its value.
RUNS = {
    f"{kind} of runs, {blocks} {what}, noise {100 * noise:g} %": (kind, blocks, noise)
    for kind, what, numbers in (
        ("saltelli", "blocks", (16, 32, 64)),
        ("morris", "trajectories", (10, 20, 40)),
    )
    for blocks in numbers
    for noise in (0.0, 0.05, 0.2, 0.3)
}

#: Functions of the runs.
FUNCTIONS: tuple[Function, ...] = (
    flat,
    ishigami,
    lambda x: g_function(np.column_stack([x, np.full(len(x), 0.25)])),
)


@lru_cache
def true_indices(function: Function, dimensions: int) -> np.ndarray:
    predictor = MadePredictor(lambda *x: function(np.column_stack(x)), [[0, 1]] * dimensions)
    return sobol_indices(predictor, TRUE_BLOCKS)["value"].to_numpy()


def of_surrogate(case: tuple, seed: int) -> pd.DataFrame:
    """Return the indices of the surrogate of a case; a refusal where there are none."""
    function, dimensions, count, noise, edge = case
    x = design(count, dimensions, seed)
    rng = np.random.default_rng(seed)
    beds = function(x)[:, None] * (1 + noise * rng.normal(size=(count, 2)))
    surrogate = fitted(x, beds, unit_axes(dimensions), x[:, 0] >= edge)
    require_small_error(surrogate, None, "made")
    return indices_of_surrogate(surrogate, blocks=BLOCKS)


def of_runs(function: Function, case: tuple, seed: int) -> pd.DataFrame:
    kind, blocks, noise = case
    runs, shares, places = made_runs(function, kind, blocks, seed=seed, noise=noise)
    if kind == "morris":
        return morris_indices_of_runs(runs, shares, places, [True] * 3)
    return sobol_indices_of_runs(runs)


@lru_cache
def true_of_runs(function: Function, kind: str) -> np.ndarray:
    if kind == "morris":
        return of_runs(function, (kind, 1000, 0.0), 1)["value"].to_numpy()
    return true_indices(function, 3)[:7]


def questions(name: str, designs: int | None = None) -> Iterator[Question]:
    """Yield the question of each design of a case."""
    seeds = range(1, (designs or DESIGNS) + 1)
    if name in SURROGATES:
        case = SURROGATES[name]
        asked = [(true_indices(*case[:2]), partial(of_surrogate, case))]
    else:
        asked = [
            (true_of_runs(f, RUNS[name][0]), partial(of_runs, f, RUNS[name])) for f in FUNCTIONS
        ]
    for truth, ask in asked:
        slack = np.full(truth.shape, DIGITS * max(1.0, np.abs(truth).max()))
        yield from ((partial(ask, seed), truth, slack) for seed in seeds)


if __name__ == "__main__":
    every = (*SURROGATES, *RUNS)
    print_table(
        __doc__, HEADINGS, every, lambda name, designs: cells(name, questions(name, designs))
    )
