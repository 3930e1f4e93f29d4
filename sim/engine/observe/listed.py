"""The contacts of one moment as a list."""

from typing import NamedTuple

import numpy as np


class Listed(NamedTuple):
    """The contacts of one moment, ``number`` (1,) of them.

    The first rows of ``pair`` (K, 2) hold the numbers of both partners, those of ``force`` (K, D)
    the force on the first (N); the others are not-a-number. What plane, belt and obstacle are
    called, `sim.parameters.variables` says. Contacts beyond K are counted alone.
    """

    number: np.ndarray
    pair: np.ndarray
    force: np.ndarray


def no_contacts(most: int, axes: int = 3) -> Listed:
    """Return room for so many contacts in so many directions, of which there is none."""
    nothing = (np.full((most, width), np.nan) for width in (2, axes))
    return Listed(np.zeros(1, np.int64), *nothing)
