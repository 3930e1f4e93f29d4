"""Where a process lives: points of the unit cube, or groups of parameters, and a scale."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.parameters.forms import Form
from sim.study.design import Axis
from sim.surrogates.predictor import scaled


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
