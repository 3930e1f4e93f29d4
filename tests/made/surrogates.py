"""Made-up samples and runs for answers: known functions of known points, with known noise."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr
from scipy.stats import qmc

from sim.study.design import Axis, block_size, unit_points
from sim.study.surrogate import SurrogateFile
from sim.surrogates import indices, posterior, propagation
from sim.surrogates.indices import DesignRuns
from sim.surrogates.surrogate import Surrogate

#: Parameters of a made-up chute.
AXES = (Axis("friction", 0.2, 0.8), Axis("depth", 2.0, 10.0), Axis("stiffness", 1e2, 1e4, "log"))


@contextmanager
def rough_answers() -> Iterator[None]:
    """Let chains and samples be short: for tests of what is told, not of numbers."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(posterior, "_STEPS", 200)
        patch.setattr(posterior, "LONG_ENOUGH", 4)
        for module in (indices, propagation):
            patch.setattr(module, "_REALISATIONS", 2)
        yield


def smooth(x: np.ndarray) -> np.ndarray:
    """Return a smooth function at points (n, d) of the unit cube, 0.5 to 3."""
    return 0.5 + np.exp(x[:, 0]) * (0.3 + 0.5 * x[:, 1] ** 2) + 0.2 * x[:, -1]


def kinked(x: np.ndarray) -> np.ndarray:
    """Return a function with a kink, as the onset of transport."""
    return 1 + np.maximum(0, x[:, 0] + 0.6 * x[:, 1] - 0.5 * x[:, -1] - 0.35)


def design(count: int, dimensions: int, seed: int = 1) -> np.ndarray:
    """Return points of the unit cube, (count, dimensions)."""
    return qmc.Sobol(dimensions, rng=seed).random_base2(int(np.ceil(np.log2(count))))[:count]


def made_sample(
    x: np.ndarray,
    mean: np.ndarray,
    axes: Sequence[Axis] = AXES[:2],
    error: float | np.ndarray = 0.0,
    regime: Sequence[str] | None = None,
    scatter: bool = False,
) -> xr.Dataset:
    """Return a sample at points (n, d) of the unit cube of some axes."""
    count = len(x)
    columns: dict[str, np.ndarray] = {}
    for axis, shares in zip(axes, x.T, strict=True):
        if axis.choices:
            columns[axis.name] = np.array(axis.choices, object)[
                (shares * len(axis.choices)).astype(int)
            ]
        elif axis.scale == "log":
            columns[axis.name] = axis.low * (axis.high / axis.low) ** shares
        else:
            columns[axis.name] = axis.low + (axis.high - axis.low) * shares
    columns |= {
        "mean": mean,
        "standard_error": np.broadcast_to(np.asarray(error, float), count).copy(),
        "replicates": np.full(count, 3),
        "regime": np.array(["steady"] * count if regime is None else list(regime), object),
        "core_hours": np.full(count, 0.01),
    }
    fixed = {"restitution": 0.85, "law": "walton_braun"}
    return xr.Dataset(
        {name: ("point", values) for name, values in columns.items()},
        {"point": [f"made-{number}" for number in range(count)]},
        {"scatter": int(scatter), "fixed": fixed},
    )


def asked(axes: Sequence[Axis] = AXES[:2], system: str = "chute", **keys: object) -> SurrogateFile:
    """Return a question for a surrogate over some axes."""
    keys = {"name": "speed", "series": "wide", **keys}
    return SurrogateFile(**keys).with_values(system=system, axes=tuple(axes))


def made_surrogate(
    function: Callable[[np.ndarray], np.ndarray] = smooth,
    count: int = 24,
    axes: Sequence[Axis] = AXES[:2],
    **options: object,
) -> Surrogate:
    """Return the surrogate of a function of the unit cube, exact at its points."""
    x = design(count, len(axes))
    spec = asked(axes)
    return Surrogate.fit(spec, made_sample(x, function(x), axes, **options))


Function = Callable[[np.ndarray], np.ndarray]


def made_runs(
    function: Function,
    kind: str,
    blocks: int,
    dimensions: int = 3,
    seed: int = 1,
    noise: float = 0.0,
    replicates: int = 2,
    places: Callable[[np.ndarray], np.ndarray] = lambda shares: shares,
) -> tuple[DesignRuns, np.ndarray, np.ndarray]:
    """Return runs of a design, the shares that it asks for and the places that it runs, (n, k).

    ``noise`` is the standard deviation of each replicate, relative to its value.
    """
    size = blocks * block_size(kind, dimensions)
    names = tuple("xyzuvwst"[:dimensions])
    shares = next(unit_points(kind, dimensions, size, seed))[:size]
    run = places(shares)
    points, number = np.unique(run, axis=0, return_inverse=True)
    values = function(points)[:, None] * np.ones(replicates)
    values *= 1 + noise * np.random.default_rng(seed).normal(size=values.shape)
    variances = values.var(axis=1, ddof=1) / replicates if replicates > 1 else np.nan * values[:, 0]
    means, number = values.mean(axis=1), number.ravel()
    return DesignRuns(names, means[number], variances[number], number), shares, run
