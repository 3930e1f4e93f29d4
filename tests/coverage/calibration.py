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
from sim.surrogates.sample import scaled, standard_errors
from sim.surrogates.surrogate import Surrogate
from tests.coverage.rows import print_table
from tests.made.surrogates import asked, made_sample

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


def everything(friction: np.ndarray, restitution: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return that every bed flows."""
    return np.ones(np.broadcast_shapes(np.shape(friction), np.shape(angle)), bool)


@dataclass(frozen=True)
class Case:
    """Measurements of materials, and a surrogate.

    ``noise`` of its runs and ``error`` of measurements are relative; ``said`` is what the file says
    of the latter. ``looked_for`` names parameters, the others are known. Materials are those for
    which ``counts`` says that beds flow at every angle.
    """

    name: str
    points: int
    noise: float
    measurements: int
    error: float
    said: float = 0.0
    replicates: int = 2
    looked_for: tuple[str, ...] = ("friction", "restitution")
    counts: Callable = everything
    has_discrepancy: bool = True
    has_chains: bool = False


_ONE = {"looked_for": ("friction",)}
_SMOOTH, _ROUGH = {"points": 32, "noise": 0.05}, {"points": 16, "noise": 0.15}
_FEW, _MANY = {"measurements": 3, "error": 0.03}, {"measurements": 40, "error": 0.01}

CASES = (
    Case("smooth", **_SMOOTH, **_FEW),
    Case("smooth", **_SMOOTH, **_MANY),
    Case("smooth, no discrepancy", **_SMOOTH, **_FEW, has_discrepancy=False),
    Case("smooth, no discrepancy", **_SMOOTH, **_MANY, has_discrepancy=False),
    Case("smooth, half the error said", **_SMOOTH, **_FEW, said=0.015),
    Case("smooth, half the error said", **_SMOOTH, **_MANY, said=0.005),
    Case("smooth, one parameter", **_SMOOTH, **_FEW, **_ONE),
    Case("smooth, one parameter", **_SMOOTH, **_MANY, **_ONE),
    Case("rough", **_ROUGH, **_FEW),
    Case("rough", **_ROUGH, **_MANY),
    Case("rough, half the error said", **_ROUGH, **_MANY, said=0.005),
    Case("rough, one parameter", **_ROUGH, **_MANY, **_ONE),
    Case("some rest", **_SMOOTH, **_FEW, counts=flows),
    Case("some rest", **_SMOOTH, **_MANY, counts=flows),
    Case("some rest, one parameter", **_SMOOTH, **_FEW, **_ONE, counts=flows),
    Case("smooth, chains", **_SMOOTH, **_FEW, has_chains=True),
    Case("rough, chains", **_ROUGH, **_MANY, has_chains=True),
)


@lru_cache(maxsize=200)
def surrogate_of(
    points: int, noise: float, replicates: int, counts: Callable, seed: int
) -> Surrogate:
    """Return a surrogate of the made-up flow."""
    rng = np.random.default_rng(seed)
    x = qmc.Sobol(len(AXES), rng=seed).random(points)
    bounds = np.array([(axis.low, axis.high) for axis in AXES])
    places = scaled(x, bounds, ["linear"] * len(AXES)).T
    exact = velocity(*places)[:, None]
    values = exact * (1 + noise * rng.normal(size=(points, replicates)))
    is_flow = counts(*places)
    values[~is_flow] = 0.0
    errors, is_unknown = standard_errors(list(values), np.zeros(points), x)
    regime = np.where(is_flow, "steady", "arrested")
    sample = made_sample(x, values.mean(axis=1), AXES, errors, regime, is_unknown)
    spec = asked(AXES)
    return Surrogate.fit(spec, sample)


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
        surrogate_of(case.points, case.noise, case.replicates, case.counts, seed),
        {axis.name: (axis.low, axis.high) for axis in AXES if axis.name in case.looked_for},
        {name: np.full(len(angles), truth[name]) for name in known} | {"angle": angles},
        values,
        (case.said or case.error) * np.abs(values),
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
        ends = np.array(
            [_quantiles(axis, weights, k, (LOST, 1 - LOST)) for k, axis in enumerate(axes)]
        )
        wide, edges = (
            (high - low) / STEPS[count],
            [_quantiles(axis, weights, k, INTERVAL) for k, axis in enumerate(axes)],
        )
        low, high = np.maximum(0, ends[:, 0] - wide), np.minimum(1, ends[:, 1] + wide)
    chosen = np.random.default_rng(0).choice(weights.size, DRAWS, p=weights.ravel())
    size, place = np.divmod(chosen, len(shares))
    draws = np.column_stack([shares[place], _sizes(calibration)[size]])
    check = check_draws(calibration, draws[:, : count + calibration.has_discrepancy])
    if check.probability < LEAST_PROBABILITY or check.uncounted > MOST_UNCOUNTED:
        return None
    found = scaled(np.array(edges).T, calibration.bounds, calibration.scales).T
    return dict(zip(calibration.names, found, strict=True))


def _sizes(calibration: Calibration) -> np.ndarray:
    """Return sizes of the discrepancy over its scale."""
    return np.linspace(0, 3, SIZES) if calibration.has_discrepancy else np.zeros(1)


def _weights(calibration: Calibration, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, p) of a grid and their probabilities (sizes, n)."""
    shares = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    parts = []
    for part in calibration.parts(shares):
        predicted = calibration.predict(part)
        parts.append(
            [
                calibration.log_density(
                    predicted,
                    np.column_stack([part, np.full(len(part), size)])[
                        :, : len(axes) + calibration.has_discrepancy
                    ],
                )
                for size in _sizes(calibration)
            ]
        )
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


@dataclass(frozen=True)
class Row:
    """What the designs of a case give; ``held`` counts intervals that hold the truth, by parameter.

    ``length`` is the mean of an interval over that of its range.
    """

    case: Case
    designs: int
    answers: int
    held: dict[str, int]
    length: float

    @property
    def share(self) -> float:
        """Share of the intervals that hold the truth."""
        return sum(self.held.values()) / max(1, self.answers * len(self.held))

    @property
    def cells(self) -> tuple[str, ...]:
        """The row in the table."""
        return (
            *(self.case.name, str(self.case.measurements), f"{self.answers} of {self.designs}"),
            *(str(self.held.get(axis.name, "")) for axis in AXES[:2]),
            *(f"{100 * self.share:.1f}", f"{self.length:.2f}"),
        )


def row_of(case: Case, designs: int | None = None) -> Row:
    """Return how often a case holds the truth."""
    solve = intervals_of_chains if case.has_chains else intervals_on_a_grid
    count, answers = designs or (CHAINS if case.has_chains else DESIGNS), 0
    held, lengths = dict.fromkeys(case.looked_for, 0), []
    for seed in range(count):
        truth, calibration = question(case, seed)
        if calibration.predictor.error > LARGE_ERROR:
            continue
        found = solve(calibration)
        if found is None:
            continue
        answers += 1
        for name, value in truth.items():
            low, _, high = found[name]
            held[name] += int(low <= value <= high)
            lengths.append((high - low) / np.ptp(calibration.ranges[name]))
    return Row(case, count, answers, held, float(np.mean(lengths)) if lengths else np.nan)


HEADINGS = (
    *("case", "measurements", "answers", "friction held", "restitution held", "held (%)"),
    "length over that of the range",
)

if __name__ == "__main__":
    print_table(__doc__, HEADINGS, CASES, lambda case, designs: row_of(case, designs).cells)
