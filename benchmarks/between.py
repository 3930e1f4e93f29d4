"""Answers between points by Talus and by libraries: Q², and how often intervals hold the truth.

`python -m benchmarks.between` prints a table of docs/validation.md. All get the same points.
OpenTURNS is asked where it is installed (`pip install openturns`); studies do not need it.
"""

import warnings
from collections.abc import Callable, Iterator
from importlib.util import find_spec

import numpy as np
from scipy.stats import qmc

from sim.base.statistics import MANY, student
from sim.surrogates.fit import fit_process
from sim.verify.exact import g_function, ishigami
from tests.coverage.surrogates import Function, eight

#: Scrambles of each design, points of each, and places where it is compared.
SCRAMBLES, POINTS, PLACES = 5, 64, 2000

#: Random starts of a fit by scikit-learn, and bounds of its lengths: with its own it falls behind.
STARTS, LENGTHS = 4, (0.05, 20.0)

#: Function, its parameters, and noise relative to its scatter.
CASES: dict[str, tuple[Function, int, float]] = {
    f"{name}{', 10 % noise' if noise else ''}": (function, dimensions, noise)
    for name, function, dimensions in (
        ("Ishigami", ishigami, 3),
        ("Sobol' G", g_function, 4),
        ("smooth, 8 parameters", eight, 8),
    )
    for noise in (0.0, 0.1)
}

#: Returns means and standard deviations at places, from points, values and their variance.
Asked = Callable[[np.ndarray, np.ndarray, float, np.ndarray], tuple[np.ndarray, np.ndarray]]


def by_talus(
    x: np.ndarray, y: np.ndarray, variance: float, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    return fit_process(x, y, np.full(len(y), variance), False).predict(places)


def by_scikit_learn(exponent: float) -> Asked:
    """Return a process with the kernel of Matérn of an exponent, and white noise."""

    def ask(
        x: np.ndarray, y: np.ndarray, variance: float, places: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

        shape = Matern(np.ones(x.shape[1]), LENGTHS, nu=exponent)
        kernel = ConstantKernel() * shape + WhiteKernel(1e-2)
        process = GaussianProcessRegressor(
            kernel, normalize_y=True, n_restarts_optimizer=STARTS, random_state=0
        ).fit(x, y)
        mean, spread = process.predict(places, return_std=True)
        noise = process.kernel_.k2.noise_level * y.var()
        return mean, np.sqrt(np.maximum(0.0, spread**2 - noise))

    return ask


def by_openturns(
    x: np.ndarray, y: np.ndarray, variance: float, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    import openturns as ot

    ot.Log.Show(ot.Log.NONE)
    values = (y - y.mean()) / y.std()
    kernel = ot.MaternModel(np.ones(x.shape[1]), 2.5)
    kernel.activateNuggetFactor(True)
    algorithm = ot.GaussianProcessFitter(
        ot.Sample(x),
        ot.Sample(values[:, None]),
        kernel,
        ot.ConstantBasisFactory(x.shape[1]).build(),
    )
    algorithm.run()
    regression = ot.GaussianProcessRegression(algorithm.getResult())
    regression.run()
    found = regression.getResult()
    mean = np.array(found.getMetaModel()(ot.Sample(places))).ravel()
    spread = ot.GaussianProcessConditionalCovariance(found)
    variances = np.array(spread.getConditionalMarginalVariance(ot.Sample(places))).ravel()
    return y.mean() + y.std() * mean, y.std() * np.sqrt(np.maximum(0.0, variances))


ASKED: dict[str, Asked] = {
    "Talus": by_talus,
    "scikit-learn, Matérn 5/2": by_scikit_learn(2.5),
    "scikit-learn, squared exponential": by_scikit_learn(np.inf),
} | ({"OpenTURNS, defaults": by_openturns} if find_spec("openturns") else {})


def lines() -> Iterator[str]:
    """Yield the lines of the table, in Markdown: Q² and share of truths within 95 %."""
    yield "| | " + " | ".join(CASES) + " |"
    yield "| --- |" + " --- |" * len(CASES)
    for name, ask in ASKED.items():
        cells = []
        for function, dimensions, noise in CASES.values():
            pairs = [_compared(ask, function, dimensions, noise, k) for k in range(SCRAMBLES)]
            quality, held = np.mean(pairs, axis=0)
            cells.append(f"{quality:.3f}, {100 * held:.0f} %")
        yield f"| {name} | " + " | ".join(cells) + " |"


def _compared(
    ask: Asked, function: Function, dimensions: int, noise: float, seed: int
) -> tuple[float, float]:
    rng = np.random.default_rng(1000 + seed)
    x = qmc.Sobol(dimensions, rng=seed).random(POINTS)
    places = rng.random((PLACES, dimensions))
    truth, exact = function(places), function(x)
    size = noise * exact.std()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mean, error = ask(x, exact + size * rng.normal(size=POINTS), size**2, places)
    quality = 1 - np.mean((mean - truth) ** 2) / truth.var()
    return float(quality), float(np.mean(np.abs(mean - truth) <= student(MANY) * error))


if __name__ == "__main__":
    for line in lines():
        print(line, flush=True)
