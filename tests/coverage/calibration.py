"""How often the intervals of calibrations hold the truth: a row for each kind of measurement.

`python -m tests.coverage.calibration` prints the table of docs/validation.md. Each design has its
own runs, surrogate, material and measurements. Posteriors are worked out on a grid, which takes a
twentieth of the time of chains; the last rows have chains.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.stats import qmc

from sim.study.design import Axis
from sim.study.surrogate import LARGE_ERROR
from sim.surrogates.likelihood import Calibration
from sim.surrogates.posterior import (
    INTERVAL,
    LEAST_PROBABILITY,
    MOST_UNCOUNTED,
    calibrate,
    check_draws,
    summarize,
)
from sim.surrogates.process import on_one_thread
from sim.surrogates.sample import scaled
from sim.surrogates.surrogate import Surrogate
from tests.coverage.rows import fitted, print_table

#: Designs of a row, and of one with chains.
DESIGNS, CHAINS = 40, 8

#: Steps of a grid along each parameter, sizes of the discrepancy, and draws for the check of a fit.
STEPS, SIZES, DRAWS = {1: 120, 2: 28}, 6, 400

#: Share of the probability that a finer grid may lose at each end of a parameter.
LOST = 1e-5

#: What is varied: two parameters of a material, and a condition.
AXES = (Axis("friction", 0.2, 0.8), Axis("restitution", 0.6, 0.98), Axis("angle", 15.0, 35.0))

#: Angles between which measurements are.
ANGLES = (17.0, 34.0)


def velocity(friction: np.ndarray, restitution: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the velocity of a made-up flow (m/s)."""
    return (angle / 20) ** 2 / (0.3 + friction) * (1 + (angle / 30) * restitution**2)


def flows(friction: np.ndarray, restitution: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return whether a bed flows, in the cases where some rest."""
    return np.tan(np.radians(angle)) > 0.65 * friction + 0 * restitution


def everything(*values: np.ndarray) -> np.ndarray:
    return np.ones(np.broadcast_shapes(*map(np.shape, values)), bool)


@dataclass(frozen=True)
class Case:
    """Measurements of materials, and a surrogate.

    ``noise`` of its runs and ``error`` of measurements are relative; the file may say half of the
    latter. ``looked_for`` names parameters, the others are known. Materials are those for which
    ``counts`` says that beds flow at every angle.
    """

    name: str
    points: int
    noise: float
    measurements: int
    error: float
    is_half_said: bool = False
    looked_for: tuple[str, ...] = ("friction", "restitution")
    counts: Callable = everything
    has_discrepancy: bool = True
    has_chains: bool = False


_ONE = {"looked_for": ("friction",)}
_SMOOTH, _ROUGH = {"points": 32, "noise": 0.05}, {"points": 16, "noise": 0.15}
_FEW, _MANY = {"measurements": 3, "error": 0.03}, {"measurements": 40, "error": 0.01}
_BOTH = (_FEW, _MANY)

CASES = (
    *(Case("smooth", **_SMOOTH, **one) for one in _BOTH),
    *(Case("smooth, no discrepancy", **_SMOOTH, **one, has_discrepancy=False) for one in _BOTH),
    *(Case("smooth, half the error said", **_SMOOTH, **one, is_half_said=True) for one in _BOTH),
    *(Case("smooth, one parameter", **_SMOOTH, **one, **_ONE) for one in _BOTH),
    *(Case("rough", **_ROUGH, **one) for one in _BOTH),
    Case("rough, half the error said", **_ROUGH, **_MANY, is_half_said=True),
    Case("rough, one parameter", **_ROUGH, **_MANY, **_ONE),
    *(Case("some rest", **_SMOOTH, **one, counts=flows) for one in _BOTH),
    Case("some rest, one parameter", **_SMOOTH, **_FEW, **_ONE, counts=flows),
    Case("smooth, chains", **_SMOOTH, **_FEW, has_chains=True),
    Case("rough, chains", **_ROUGH, **_MANY, has_chains=True),
)


@lru_cache(maxsize=200)
def surrogate_of(points: int, noise: float, counts: Callable, seed: int) -> Surrogate:
    """Return a surrogate of the made-up flow."""
    rng = np.random.default_rng(seed)
    x = qmc.Sobol(len(AXES), rng=seed).random(points)
    bounds = np.array([(axis.low, axis.high) for axis in AXES])
    places = scaled(x, bounds, ["linear"] * len(AXES)).T
    exact = velocity(*places)[:, None]
    values = exact * (1 + noise * rng.normal(size=(points, 2)))
    is_flow = counts(*places)
    values[~is_flow] = 0.0
    return fitted(x, values, AXES, is_flow)


def question(case: Case, seed: int) -> tuple[dict[str, float], Calibration]:
    """Return a material, and measurements of it."""
    rng = np.random.default_rng(10_000 + seed)
    angles = np.linspace(*ANGLES, case.measurements)
    while True:
        truth = {axis.name: float(rng.uniform(axis.low, axis.high)) for axis in AXES[:2]}
        if case.counts(truth["friction"], truth["restitution"], angles).all():
            break
    exact = velocity(truth["friction"], truth["restitution"], angles)
    values = exact * (1 + case.error * rng.normal(size=len(angles)))
    known = [name for name in truth if name not in case.looked_for]
    return {name: truth[name] for name in case.looked_for}, Calibration(
        surrogate_of(case.points, case.noise, case.counts, seed),
        {axis.name: (axis.low, axis.high) for axis in AXES if axis.name in case.looked_for},
        {name: np.full(len(angles), truth[name]) for name in known} | {"angle": angles},
        values,
        case.error / (2 if case.is_half_said else 1) * np.abs(values),
        "velocity",
        case.has_discrepancy,
        seed,
    )


@on_one_thread
def intervals_on_a_grid(calibration: Calibration) -> dict[str, np.ndarray] | None:
    """Return the 95 % interval of each parameter, or nothing where nothing fits.

    A second grid is finer, where the first has found the probability.
    """
    count = len(calibration.names)
    low, high = np.zeros(count), np.ones(count)
    for _ in range(2):
        axes = np.linspace(low, high, 2 * STEPS[count] + 1)[1::2].T
        shares, weights = _weights(calibration, axes)
        edges, ends = (
            np.array([_quantiles(axis, weights, k, chances) for k, axis in enumerate(axes)])
            for chances in (INTERVAL, (LOST, 1 - LOST))
        )
        wide = (high - low) / STEPS[count]
        low, high = np.maximum(0, ends[:, 0] - wide), np.minimum(1, ends[:, 1] + wide)
    chosen = np.random.default_rng(0).choice(weights.size, DRAWS, p=weights.ravel())
    size, place = np.divmod(chosen, len(shares))
    draws = np.column_stack([shares[place], _sizes(calibration)[size]])
    check = check_draws(calibration, draws[:, : count + calibration.has_discrepancy])
    if check.probability < LEAST_PROBABILITY or check.uncounted > MOST_UNCOUNTED:
        return None
    found = scaled(edges.T, calibration.bounds, calibration.scales).T
    return dict(zip(calibration.names, found, strict=True))


def _sizes(calibration: Calibration) -> np.ndarray:
    """Return sizes of the discrepancy over its scale."""
    return np.linspace(0, 3, SIZES) if calibration.has_discrepancy else np.zeros(1)


def _weights(calibration: Calibration, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, p) of a grid and their probabilities (sizes, n)."""
    shares = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    columns, parts = len(axes) + calibration.has_discrepancy, []
    for part in calibration.parts(shares):
        predicted = calibration.predict(part)
        draws = (np.insert(part, len(axes), size, axis=1) for size in _sizes(calibration))
        parts.append([calibration.log_density(predicted, one[:, :columns]) for one in draws])
    logs = np.concatenate(parts, axis=1)
    weights = np.exp(logs - logs.max())
    return shares, weights / weights.sum()


def _quantiles(
    axis: np.ndarray, weights: np.ndarray, which: int, chances: tuple[float, ...]
) -> np.ndarray:
    """Return quantiles of a parameter; probability is even within a cell."""
    count = len(weights[0])
    dimensions = round(np.log(count) / np.log(len(axis)))
    table = weights.sum(axis=0).reshape((len(axis),) * dimensions)
    others = tuple(k for k in range(dimensions) if k != which)
    summed = np.concatenate([[0], np.cumsum(table.sum(axis=others))])
    half = (axis[1] - axis[0]) / 2
    return np.interp(chances, summed, np.concatenate([axis - half, axis[-1:] + half]))


def intervals_of_chains(calibration: Calibration) -> dict[str, np.ndarray] | None:
    """Return what `intervals_on_a_grid` does, by emcee."""
    groups = calibrate(calibration)
    if "posterior" not in groups:
        return None
    rows = summarize(groups)
    return {row.parameter: np.array([row.low, row.median, row.high]) for row in rows.itertuples()}


def row_of(case: Case, designs: int | None = None) -> tuple[int, int, dict[str, int], float]:
    """Return how many designs a case has, how many an answer, and what their intervals hold.

    That is how many hold the truth, by parameter, and their mean length over that of the range.
    """
    solve = intervals_of_chains if case.has_chains else intervals_on_a_grid
    count, answers = designs or (CHAINS if case.has_chains else DESIGNS), 0
    held, lengths = dict.fromkeys(case.looked_for, 0), []
    for seed in range(count):
        truth, calibration = question(case, seed)
        if calibration.predictor.error > LARGE_ERROR or not (found := solve(calibration)):
            continue
        answers += 1
        for name, value in truth.items():
            low, _, high = found[name]
            held[name] += int(low <= value <= high)
            lengths.append((high - low) / np.ptp(calibration.ranges[name]))
    return count, answers, held, float(np.mean(lengths)) if lengths else np.nan


def share_held(answers: int, held: dict[str, int]) -> float:
    """Return the share of the intervals that hold the truth."""
    return sum(held.values()) / max(1, answers * len(held))


def cells(case: Case, designs: int | None = None) -> tuple[str, ...]:
    """Return the row of a case in the table."""
    count, answers, held, length = row_of(case, designs)
    return (
        *(case.name, str(case.measurements), f"{answers} of {count}"),
        *(f"{100 * share_held(answers, held):.1f}", f"{length:.2f}"),
    )


HEADINGS = (*("case", "measurements", "answers", "held (%)", "length over that of the range"),)

if __name__ == "__main__":
    print_table(__doc__, HEADINGS, CASES, cells)
