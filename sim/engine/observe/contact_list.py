"""The contacts of one moment as a list."""

from typing import NamedTuple

import numpy as np


class ContactList(NamedTuple):
    """The contacts of one moment; ``number`` (1,) is their number.

    Row by row ``pair`` (K, 2) holds the numbers of the two partners, and ``force`` (K, D) the force
    on the first of them (N). Unused rows are not-a-number. `sim.parameters.variables` defines the
    numbers of plane, belt and obstacle. Contacts beyond K are counted but not listed.
    """

    number: np.ndarray
    pair: np.ndarray
    force: np.ndarray


def no_contacts(most: int, axes: int = 3) -> ContactList:
    """Return an empty list with space for ``most`` contacts in ``axes`` directions."""
    arrays = (np.full((most, width), np.nan) for width in (2, axes))
    return ContactList(np.zeros(1, np.int64), *arrays)
