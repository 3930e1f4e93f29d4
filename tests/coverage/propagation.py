"""How often the intervals of propagations hold the truth: a row for each kind of question.

`python -m tests.coverage.propagation` prints the table of docs/validation.md. The truth is by brute
force. The cantilever beam and the short column are test problems of Dakota's user's manual (Sues,
Aminpour and Shin 2001; Kuschel and Rackwitz 1997); the column's strength is normal here, its load
and moment independent.
"""

from collections.abc import Iterator
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import truncnorm

from sim.study.design import Axis, unit_points
from sim.surrogates.indices import DesignRuns
from sim.surrogates.inquiries import require_small_error
from sim.surrogates.propagation import spread_of_runs, spread_of_surrogate
from sim.surrogates.sample import unscaled
from tests.coverage.rows import HEADINGS, Question, cells, fitted, print_table
from tests.made.surrogates import smooth

#: Designs of a case; draws of a surrogate, and of a truth.
DESIGNS, DRAWS, TRUE_DRAWS = 40, 2**9, 2**18

QUANTILES = (0.25, 0.5, 0.75, 0.9)


def normal(name: str, mean: float, deviation: float) -> Axis:
    return Axis(name, mean - 4 * deviation, mean + 4 * deviation, normal=(mean, deviation))


def cantilever(x: np.ndarray) -> np.ndarray:
    """Displacement of the end of a beam of width and thickness 2.5."""
    modulus, across, along = x.T
    return 4e6 / (modulus * 2.5**2) * np.hypot(along / 2.5**2, across / 2.5**2)


def short_column(x: np.ndarray) -> np.ndarray:
    """Limit state of a column of 5 by 15, which fails below 0."""
    load, moment, strength = x.T
    return 1 - 4 * moment / (5 * 15**2 * strength) - (load / (5 * 15 * strength)) ** 2


def skewed(x: np.ndarray) -> np.ndarray:
    return np.exp(0.6 * x[:, 0] + 0.3 * x[:, 1])


UNIT = tuple(Axis(f"x{number}", 0.0, 1.0) for number in range(3))
BEAM = (normal("E", 2.9e7, 1.45e6), normal("X", 500, 100), normal("Y", 1000, 100))
COLUMN = (normal("P", 500, 100), normal("M", 2000, 400), normal("S", 5, 0.5))
LOGNORMAL = (normal("x0", 0, 1), normal("x1", 0, 1))


class Case(NamedTuple):
    """Function, parameters, value to exceed, runs, their kind, noise of a replicate."""

    function: object
    axes: tuple[Axis, ...]
    above: float
    runs: int
    kind: str = "random"
    noise: float = 0.0
    surrogate: bool = False


CASES = {
    "cantilever, 32 runs": Case(cantilever, BEAM, 4.5, 32),
    "the same, spread by Sobol'": Case(cantilever, BEAM, 4.5, 32, "sobol"),
    "cantilever, 128 runs": Case(cantilever, BEAM, 4.5, 128),
    "short column, 64 runs": Case(short_column, COLUMN, 0.7, 64),
    "lognormal, 64 runs": Case(skewed, LOGNORMAL, 2.0, 64),
    "smooth, 64 runs, noise 5 %": Case(smooth, UNIT, 2.0, 64, noise=0.05),
    "smooth, 64 runs, noise 20 %": Case(smooth, UNIT, 2.0, 64, noise=0.2),
    "cantilever, surrogate of 32 runs": Case(cantilever, BEAM, 4.5, 32, "sobol", surrogate=True),
    "short column, surrogate of 64 runs": Case(
        short_column, COLUMN, 0.7, 64, "sobol", surrogate=True
    ),
    "smooth, surrogate of 32 runs, noise 5 %": Case(smooth, UNIT, 2.0, 32, "sobol", 0.05, True),
    "smooth, surrogate of 32 runs, noise 20 %": Case(smooth, UNIT, 2.0, 32, "sobol", 0.2, True),
}


def exact(axis: Axis, shares: np.ndarray) -> np.ndarray:
    """Return what `Axis.values` does, not rounded."""
    if axis.normal is None:
        return axis.low + (axis.high - axis.low) * shares
    mean, deviation = axis.normal
    return truncnorm.ppf(shares, -4, 4, mean, deviation)


def draw(case: Case, seed: int) -> np.ndarray:
    shares = next(unit_points(case.kind, len(case.axes), case.runs, seed))[: case.runs]
    columns = zip(case.axes, shares.T, strict=True)
    return np.column_stack([axis.values(column) for axis, column in columns])


@lru_cache
def truth(case: Case) -> np.ndarray:
    rng = np.random.default_rng(0)
    x = np.column_stack([exact(axis, rng.random(TRUE_DRAWS)) for axis in case.axes])
    values = case.function(x)
    above = (values > case.above).mean()
    return np.array([values.mean(), values.std(), *np.quantile(values, QUANTILES), above])


def asked(case: Case, seed: int) -> pd.DataFrame:
    """Return the answer to a case; raise a refusal where there is none."""
    x, rng = draw(case, seed), np.random.default_rng(seed)
    beds = case.function(x)[:, None] * (1 + case.noise * rng.normal(size=(case.runs, 2)))
    question = QUANTILES, (case.above,)
    if not case.surrogate:
        scatter = beds.var(axis=1, ddof=1) / 2
        runs = DesignRuns(("x",), beds.mean(axis=1), scatter, np.arange(case.runs))
        return spread_of_runs(runs, *question)
    bounds = [(axis.low, axis.high) for axis in case.axes]
    cube = unscaled(x, bounds, ["linear"] * len(bounds))
    surrogate = fitted(cube, beds, case.axes, np.full(case.runs, True))
    require_small_error(surrogate, None, "made")
    return spread_of_surrogate(surrogate, case.axes, (), *question, draws=DRAWS)


def questions(name: str, designs: int | None = None) -> Iterator[Question]:
    """Yield the question of each design of a case."""
    case = CASES[name]
    true = truth(case)
    # Brute force knows a probability to a thousandth, as it does a value of its spread.
    slack = np.append(np.full(len(true) - 1, 1e-3 * true[1]), 1e-3)
    for seed in range(1, (designs or DESIGNS) + 1):
        yield partial(asked, case, seed), true, slack


if __name__ == "__main__":
    print_table(
        __doc__, HEADINGS, CASES, lambda name, designs: cells(name, questions(name, designs))
    )
