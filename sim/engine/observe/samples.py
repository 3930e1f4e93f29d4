"""Samples of a system, its energy ledger and contacts, and sums over samples.

A sum is a named tuple of arrays, of any type, that can be added. Blocks of them let the averaging
window be chosen later.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from sim.engine.compile import exact, inlined
from sim.engine.states import refill

#: Several sums of different types, over one sample or more.
Sums = tuple[NamedTuple, ...]

_Kind = TypeVar("_Kind", bound=NamedTuple)

#: Largest number of blocks; once it is reached, pairs of blocks are merged.
MAX_BLOCKS = 64


def map_arrays(function: Callable[..., np.ndarray], *sums: _Kind) -> _Kind:
    """Return sums of the same type with a function of their arrays, or of those of several."""
    kind: Any = type(sums[0])
    arrays: Iterable[Any] = sums
    return kind(*map(function, *arrays))


def add_sums(first: Sums, second: Sums) -> Sums:
    """Return the sums of several pairs of sums, array by array."""
    return tuple(map_arrays(np.add, *pair) for pair in zip(first, second, strict=True))


def zero_samples(samples: int, template: _Kind) -> _Kind:
    """Return sums of zero like ``template``, with a first axis over the samples."""
    return map_arrays(lambda part: np.zeros((samples, *part.shape)), template)


def first_samples(sums: Sums, samples: int) -> Sums:
    """Return several sums of the first ``samples`` samples."""
    return tuple(map_arrays(lambda part: part[:samples], one) for one in sums)


def copy_sample(sums: Sums, number: int) -> Sums:
    """Return a copy of several sums of sample ``number``."""
    return tuple(map_arrays(lambda part: part[number].copy(), one) for one in sums)


def mask_samples(sums: _Kind, mask: np.ndarray) -> _Kind:
    """Return the sums by sample, set to zero where ``mask`` (K,) is false."""
    return map_arrays(lambda part: part * mask.reshape(-1, *[1] * (part.ndim - 1)), sums)


def add_samples(total: NamedTuple, sums: NamedTuple, first: int, last: int) -> None:
    """Add the sums of samples ``first`` to ``last`` - 1 to a total, one after the other."""
    for target, source in zip(total, sums, strict=True):
        _add_rows(target.reshape(-1), source.reshape(len(source), -1), first, last)


@exact
def _add_rows(total, rows, first, last):
    for row in range(first, last):
        for k in range(total.size):
            total[k] += rows[row, k]


class ProfileBlocks:
    """The profiles of a run, summed in blocks of equal numbers of samples.

    ``latest`` holds the profiles of the last sample alone, ``None`` before the first.
    """

    def __init__(self) -> None:
        self.latest: Sums | None = None
        self._blocks: list[Sums] = []
        self._length = 1
        self._filled = 0

    def state(self) -> dict[str, Any]:
        """Return all data of the blocks, by name."""
        return {
            "length": self._length,
            "filled": self._filled,
            "blocks": _stack(self._blocks),
            "latest": _stack([self.latest] if self.latest else []),
        }

    def restore(self, state: Mapping[str, Any], template: Sums) -> None:
        """Replace the data by the ``state`` of other blocks, whose sums are like ``template``.

        Raises ``ValueError`` when the state does not fit.
        """
        has_samples = any(path.startswith("latest") for path in state)
        structure = {
            name: _stack([template] if has_samples else []) for name in ("blocks", "latest")
        }
        values = refill({"length": 0, "filled": 0} | structure, state, growing_axis=0)
        self._length, self._filled = values["length"], values["filled"]
        self._blocks = _unstack(values["blocks"])
        self.latest = next(iter(_unstack(values["latest"])), None)

    def add(self, profiles: Sums) -> None:
        """Add the profiles of K samples, one per index of the first axis of the arrays."""
        count, first = len(profiles[0][0]), 0
        self.latest = copy_sample(profiles, count - 1)
        while first < count:
            last = min(count, first + self._length - self._filled)
            if self._filled == 0:
                self._blocks.append(copy_sample(profiles, first))
            start = first + (self._filled == 0)
            for total, sums in zip(self._blocks[-1], profiles, strict=True):
                add_samples(total, sums, start, last)
            self._filled = (self._filled + last - first) % self._length
            first = last
            if self._filled == 0 and len(self._blocks) == MAX_BLOCKS:
                pairs = zip(self._blocks[::2], self._blocks[1::2], strict=True)
                self._blocks = [add_sums(*pair) for pair in pairs]
                self._length *= 2

    def blocks(self) -> list[tuple[int, Sums]]:
        """Return for each block the number of samples up to its end, and its sums."""
        ends = [(number + 1) * self._length for number in range(len(self._blocks))]
        if self._filled:
            ends[-1] += self._filled - self._length
        return list(zip(ends, self._blocks, strict=True))

    def sum_since(self, start: int) -> Sums | None:
        """Return the sums over all blocks that begin at sample ``start`` or later.

        At least the last block counts; ``None`` before the first sample.
        """
        if not self._blocks:
            return None
        first = min(-(-start // self._length), len(self._blocks) - 1)
        total = self._blocks[first]
        for block in self._blocks[first + 1 :]:
            total = add_sums(total, block)
        return total


def _stack(blocks: list[Sums]) -> Sums:
    """Return sums whose arrays have an additional first axis over the blocks."""
    return tuple(
        map_arrays(lambda *parts: np.stack(parts), *group) for group in zip(*blocks, strict=True)
    )


def _unstack(stack: Sums) -> list[Sums]:
    count = len(stack[0][0]) if stack else 0
    return [copy_sample(stack, number) for number in range(count)]


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


@inlined
def append_contact(contact_list, pair, force):
    """Append a contact to a list that has room for it; count it in any case."""
    row = contact_list.number[0]
    contact_list.number[0] += 1
    if row < contact_list.pair.shape[0]:
        contact_list.pair[row, 0], contact_list.pair[row, 1] = pair
        for d in range(len(force)):
            contact_list.force[row, d] = force[d]


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
