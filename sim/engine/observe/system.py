"""The parts of the interface between a system and the recorder: samples, ledger, contacts."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from sim.engine.observe.sums import Sums


class ContactList(NamedTuple):
    """The contacts of one moment; ``number`` (1,) is their number.

    Row by row ``pair`` (K, 2) holds the numbers of the two partners, and ``force`` (K, D) the force
    on the first of them (N). Unused rows are not-a-number. `sim.parameters.variables` defines the
    numbers of plane, belt and obstacle. Contacts beyond K are counted but not listed.
    """

    number: np.ndarray
    pair: np.ndarray
    force: np.ndarray


def no_contacts(most: int, axes: int) -> ContactList:
    """Return an empty list with space for ``most`` contacts in ``axes`` directions."""
    arrays = (np.full((most, width), np.nan) for width in (2, axes))
    return ContactList(np.zeros(1, np.int64), *arrays)


class Ledger(NamedTuple):
    """The energy ledger of a system; its names are those of time series (J).

    ``terms`` name -> sign: the signed sum of these series is constant. ``turnover`` names sums
    since the start whose change measures the energy that has passed through. ``powers`` name of a
    sum since the start -> name of the scalar with its mean rate (W).
    """

    terms: dict[str, int]
    turnover: tuple[str, ...]
    powers: dict[str, str]


def make_ledger(*names: str, turnover: tuple[str, ...]) -> Ledger:
    """Return a ledger of energies, losses and works: each work came in, all else is the outcome.

    The mean rate of ``normal_loss`` is ``normal_power``, and so for each loss and work.
    """
    terms = {name: -1 if name.endswith("_work") else 1 for name in names}
    sums = [name for name in names if not name.endswith("_energy")]
    return Ledger(terms, turnover, {name: f"{name.rpartition('_')[0]}_power" for name in sums})


class Samples(NamedTuple):
    """K successive samples.

    ``values`` name -> (K,) of the time series; ``profiles`` sums of the profiles with a first axis
    over the samples, None where they were not requested. The profiles are valid until the next
    samples are taken.
    """

    values: Mapping[str, Sequence[float] | np.ndarray]
    profiles: Sums | None

    def first(self) -> dict[str, float]:
        """Return the values of the first sample."""
        return {name: float(values[0]) for name, values in self.values.items()}
