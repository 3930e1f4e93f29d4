"""How smeared out a layer of beads is, by the ranks of its beads; which of two flows has more."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import above, below
from sim.claims.place import Place
from sim.claims.verdict import Check
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


def compare(
    what: str, ratio: UFloat, margin: float, places: Iterable[Place], *, larger: bool = True
) -> Check:
    """Return the check that one quantity is larger than another, or smaller, by their ratio.

    As in `sim.claims.inference.trend` it fails only where they are surely the other way by the
    share ``margin``.
    """
    places = tuple(places)
    test, reversal = (above, 1 / (1 + margin)) if larger else (below, 1 + margin)
    check, reversed_by = (test(what, ratio, bound, places) for bound in (1, reversal))
    # Looks are spent when the p-values are read.
    p_values = replace(check, looks=0).p_holds, replace(reversed_by, looks=0).p_fails
    return replace(check, tested=p_values)
