"""How often the intervals of surrogates hold the truth: a row for each kind of function and noise.

`python -m tests.coverage.surrogates` prints the table of docs/validation.md. Each design is fitted
as a study would be, from the values of replicates to the surrogate.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from sim.base.statistics import MANY, student
from sim.surrogates.answers import Refusal
from sim.surrogates.surrogate import Surrogate
from sim.verify.exact import g_function, ishigami
from tests.coverage.rows import fitted, print_table, unit_axes
from tests.made.surrogates import kinked, smooth

#: Designs of a row, and places at which each is compared with the truth.
DESIGNS, PLACES = 40, 400

Function = Callable[[np.ndarray], np.ndarray]


def _everywhere(x: np.ndarray) -> np.ndarray:
    return np.ones(len(x), bool)


@dataclass(frozen=True)
class Case:
    """A function of the unit cube, with runs whose ``noise`` is relative to its value.

    ``counts`` says which points the mean is of; it is judged where it is of them.
    """

    name: str
    function: Function
    dimensions: int
    points: int
    noise: float | Function = 0.0
    replicates: int = 1
    counts: Function = _everywhere
    designs: int = DESIGNS


def eight(x: np.ndarray) -> np.ndarray:
    """Return a smooth function of eight parameters, some of which hardly matter."""
    return 2 + smooth(x[:, :3]) + x[:, 3:] @ np.array([0.5, 0.3, 0.1, 0.02, 0.0])


def oscillating(x: np.ndarray) -> np.ndarray:
    """Return two periods of a sine."""
    return 1 + 0.3 * np.sin(4 * np.pi * x[:, 0])


def step(height: float) -> Function:
    """Return a smooth function that jumps by a share of it."""
    return lambda x: smooth(x) * (1 + height * (x[:, 0] + 0.3 * x[:, 1] > 0.6))


def uneven(x: np.ndarray) -> np.ndarray:
    """Return a noise from 1 to 30 %."""
    return 0.01 * 30 ** x[:, 0]


def flows(x: np.ndarray) -> np.ndarray:
    """Return which points flow."""
    return x[:, 0] + 0.5 * x[:, 1] > 0.5


CASES = (
    *(Case(f"smooth, 2 parameters, 5 % noise, {r} run", smooth, 2, 16, 0.05, r) for r in (1, 2)),
    Case("smooth, 3 parameters, 5 % noise", smooth, 3, 9, 0.05, 2),
    Case("smooth, 3 parameters, 5 % noise", smooth, 3, 32, 0.05, 2),
    Case("smooth, 8 parameters, 5 % noise", eight, 8, 32, 0.05, 2),
    Case("smooth, 8 parameters, no noise", eight, 8, 64),
    Case("two periods of a sine, 2 % noise", oscillating, 1, 16, 0.02, 2),
    Case("Ishigami", ishigami, 3, 64, designs=20),
    Case("Ishigami", ishigami, 3, 128, designs=20),
    Case("Sobol' G (kinks)", g_function, 4, 64),
    Case("kink, 5 % noise", kinked, 3, 32, 0.05, 2),
    *(Case(f"noise of 1 to 30 %, {r} runs", smooth, 2, 32, uneven, r) for r in (1, 2, 3)),
    Case("step of 30 %, 1 % noise", step(0.3), 2, 32, 0.01, 3),
    Case("step of 100 %, 5 % noise", step(1.0), 2, 32, 0.05, 2),
    Case("regime that ends inside the range, 5 % noise", smooth, 2, 48, 0.05, 2, flows),
    Case(
        "4 of 48 points count, 4 parameters",
        smooth,
        4,
        48,
        0.05,
        1,
        lambda x: np.arange(len(x)) < (4 if len(x) == 48 else len(x)),
    ),
)


def surrogate_of(case: Case, seed: int) -> Surrogate:
    rng = np.random.default_rng(seed)
    x = qmc.Sobol(case.dimensions, rng=seed).random(case.points)
    size = _noise(case, x) * np.abs(case.function(x))
    values = case.function(x)[:, None] + size[:, None] * rng.normal(
        size=(case.points, case.replicates)
    )
    return fitted(x, values, unit_axes(case.dimensions), case.counts(x))


def row_of(case: Case, designs: int | None = None) -> np.ndarray:
    """Return what the designs of a case give, (4, designs); none without answer.

    First the share of truths within the 95 % interval, then the same in the third of greatest
    noise; the error that the surrogate gives itself, and the true one.
    """
    parts: list[list[float]] = []
    for seed in range(designs or case.designs):
        try:
            surrogate = surrogate_of(case, seed)
        except Refusal:
            continue
        x = np.random.default_rng(1000 + seed).random((PLACES, case.dimensions))
        x = x[case.counts(x)]
        truth = case.function(x)
        mean, error = surrogate.predict(x)
        is_held = np.abs(mean - truth) <= student(MANY) * error
        true = np.sqrt(np.mean((mean - truth) ** 2)) / np.abs(truth).mean()
        noise = _noise(case, x)
        is_noisy = noise >= np.quantile(noise, 2 / 3)
        parts.append([is_held.mean(), is_held[is_noisy].mean(), surrogate.error, true])
    return np.reshape(parts, (-1, 4)).T


def _noise(case: Case, x: np.ndarray) -> np.ndarray:
    return case.noise(x) if callable(case.noise) else np.full(len(x), case.noise)


HEADINGS = ("case", "points", "designs", "held (worst)", "noisiest third", "error said", "true")


def cells(case: Case, designs: int | None = None) -> tuple[str, ...]:
    """Return the row of a case in the table."""
    held, noisy, said, true = row_of(case, designs)
    start = (case.name, str(case.points), f"{len(held)} of {case.designs}")
    if not held.size:
        return (*start, "no answer", "", "", "")
    return (
        *(*start, f"{100 * held.mean():.1f} ({100 * held.min():.0f})"),
        f"{100 * noisy.mean():.1f}" if callable(case.noise) else "",
        *(f"{100 * np.median(one):.2g}" for one in (said, true)),
    )


if __name__ == "__main__":
    print_table(__doc__, HEADINGS, CASES, cells)
