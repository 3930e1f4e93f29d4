"""Points of the unit cube in the ranges of parameters, and forms of an observable over it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, wraps
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from sim.parameters.forms import Form
from sim.study.design import Axis


def counted_probability(surrogate: Any, probability: np.ndarray) -> np.ndarray:
    """Return the probability of the regimes that a mean is of, from that of each (regimes, ...).

    Where no regime is known, none is likelier than these.
    """
    names = surrogate.regimes.names
    if not names:
        return np.ones(probability.shape[1:])
    return np.asarray(probability[np.isin(names, surrogate.mean_regimes)].sum(axis=0))


def scaled(shares: np.ndarray, bounds: ArrayLike, scales: Sequence[str]) -> np.ndarray:
    """Return the values of parameters at points (n, k) of the unit cube."""
    low, high = np.asarray(bounds, float).T
    is_log = np.array([scale == "log" for scale in scales])
    linear = low + (high - low) * shares
    # The ratio of a range that includes 0 is not used.
    ratio = np.where(is_log, high / np.where(is_log, low, 1.0), 1.0)
    return np.where(is_log, low * ratio**shares, linear)


def unscaled(x: np.ndarray, bounds: ArrayLike, scales: Sequence[str]) -> np.ndarray:
    """Return the points of the unit cube that stand for values (n, k), as `scaled` gives them."""
    low, high = np.asarray(bounds, float).T
    is_log = np.array([scale == "log" for scale in scales])
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithmic = np.log(x / low) / np.log(high / low)
    return np.where(is_log, logarithmic, (x - low) / (high - low))


@dataclass(frozen=True)
class Frame:
    """A form of an observable over the unit cube of some axes.

    Attributes
    ----------
    form : Form
        Its scale and its groups of parameters.
    axes : tuple of Axis
        Parameters that points vary.
    fixed : mapping
        Parameters that are the same at all points.
    """

    form: Form
    axes: tuple[Axis, ...]
    fixed: Mapping[str, Any]

    def scale(self, x: np.ndarray) -> np.ndarray:
        """Return the scale of the observable (n,) at points (n, d) of the unit cube."""
        if self.form.scale is None:
            return np.ones(len(x))
        return self._column(self.form.scale, x)

    def places(self, x: np.ndarray) -> np.ndarray:
        """Return the groups at points (n, d) of the unit cube, (n, k), each in its unit."""
        columns = {f"{number}": column for number, column in enumerate(x.T)}
        at = {axis.name: f"{number}" for number, axis in self._numbers().items()}
        for name, function in self.form.inputs.items():
            columns[at.get(name, name)] = self._column(function, x)
        return np.column_stack(list(columns.values()))

    def is_usable(self, x: np.ndarray) -> bool:
        """Whether scale and groups are finite at points, and the scale is above 0."""
        try:
            scale, places = self.scale(x), self.places(x)
        except KeyError:
            # A parameter of the form differs from point to point without being an axis.
            return False
        return bool((scale > 0).all() and np.isfinite(scale).all() and np.isfinite(places).all())

    def _numbers(self) -> dict[int, Axis]:
        """Return the axes that are numbers, by their columns of the unit cube."""
        axes, column = {}, 0
        for axis in self.axes:
            if axis.is_number:
                axes[column] = axis
            column += 1 if axis.is_number or len(axis.choices) == 2 else len(axis.choices)
        return axes

    def _column(self, function: Any, x: np.ndarray) -> np.ndarray:
        numbers = self._numbers()
        axes = list(numbers.values())
        bounds = np.reshape([(axis.low, axis.high) for axis in axes], (-1, 2))
        columns = scaled(x[:, list(numbers)], bounds, [axis.scale for axis in axes]).T
        values = dict(zip([axis.name for axis in axes], columns, strict=True))
        with np.errstate(all="ignore"):
            column = np.asarray(function({**self.fixed, **values}), dtype=float)
        return np.broadcast_to(column, len(x))


Function = TypeVar("Function", bound=Callable[..., Any])


def on_one_thread(function: Function) -> Function:
    """Return a function during which BLAS computes on one thread.

    The matrices of surrogates are small: threads wait for each other longer than they compute
    (twelve times the processor time with two threads on two busy cores).
    """

    @wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        with _controller().limit(limits=1, user_api="blas"):
            return function(*args, **options)

    return call  # type: ignore[return-value]


@cache
def _controller() -> Any:
    """Return the controller of the threads of BLAS, once scikit-learn has loaded it."""
    import sklearn.gaussian_process  # noqa: F401  # it loads them
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
