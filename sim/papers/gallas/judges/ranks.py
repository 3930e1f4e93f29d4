"""How smeared out a layer of beads is, by the ranks of its beads."""

from collections.abc import Callable
from functools import cache

import numpy as np

from sim.measures.layers import level

#: Share that stands for all beads: their heights have a standard deviation as the width.
ALL = 1.0


@cache
def width_of_beads(share: float) -> Callable[[np.ndarray, np.ndarray], float]:
    """Return a function of height and number density: the width (m) of the layer.

    It is the range that holds the middle ``share`` of the beads, or the standard deviation of the
    heights of `ALL`. A threshold of density would jump where the lowest slice crosses it.
    """

    def width(height: np.ndarray, number: np.ndarray) -> float:
        if share == ALL:
            mean = np.average(height, weights=number)
            return float(np.sqrt(np.average((height - mean) ** 2, weights=number)))
        low, high = (level(height, number, 0.5 + side * share / 2) for side in (-1, 1))
        return high - low

    return width


def width_label(share: float) -> str:
    """Return the name of the width of `width_of_beads`."""
    return "standard deviation of heights" if share == ALL else f"middle {100 * share:g} % of beads"
