"""Sums of profiles over successive blocks of samples: where to start can be decided later."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.engine.flatten import refilled
from sim.engine.observe.sums import Sums, add_samples, copied, plus

#: Blocks kept; when there are as many, each two become one.
MOST = 64


class ProfileBlocks:
    """The profiles of a run, summed up in blocks of equal numbers of samples.

    ``latest`` are the profiles of the last sample alone, ``None`` before the first.
    """

    def __init__(self) -> None:
        self.latest: Sums | None = None
        self._blocks: list[Sums] = []
        self._length = 1
        self._filled = 0

    def state(self) -> dict[str, Any]:
        """Return all that is kept, by name."""
        return {
            "length": self._length,
            "filled": self._filled,
            "blocks": _stacked(self._blocks),
            "latest": _stacked([self.latest] if self.latest else []),
        }

    def restore(self, held: Mapping[str, Any], like: Sums) -> None:
        """Take over what other blocks have kept, sums ``like`` these.

        Raises ``ValueError`` when they are none.
        """
        some = any(place.startswith("latest") for place in held)
        kind = {name: _stacked([like] if some else []) for name in ("blocks", "latest")}
        found = refilled({"length": 0, "filled": 0} | kind, held, growing=0)
        self._length, self._filled = found["length"], found["filled"]
        self._blocks = _unstacked(found["blocks"])
        self.latest = next(iter(_unstacked(found["latest"])), None)

    def add(self, profiles: Sums) -> None:
        """Add the profiles of K samples, which lie along the first axis of the arrays."""
        count, first = len(profiles[0][0]), 0
        self.latest = tuple(copied(several, count - 1) for several in profiles)
        while first < count:
            last = min(count, first + self._length - self._filled)
            if self._filled == 0:
                self._blocks.append(tuple(copied(several, first) for several in profiles))
            start = first + (self._filled == 0)
            for total, several in zip(self._blocks[-1], profiles, strict=True):
                add_samples(total, several, start, last)
            self._filled = (self._filled + last - first) % self._length
            first = last
            if self._filled == 0 and len(self._blocks) == MOST:
                pairs = zip(self._blocks[::2], self._blocks[1::2], strict=True)
                self._blocks = [_plus(one, other) for one, other in pairs]
                self._length *= 2

    def each(self) -> list[tuple[int, Sums]]:
        """Return the sums of each block, and how many samples there are up to its end."""
        ends = [(number + 1) * self._length for number in range(len(self._blocks))]
        if self._filled:
            ends[-1] += self._filled - self._length
        return list(zip(ends, self._blocks, strict=True))

    def since(self, start: int) -> Sums | None:
        """Return the sums over all blocks that begin at sample ``start`` or later.

        At least the last block counts; ``None`` before the first sample.
        """
        if not self._blocks:
            return None
        first = min(-(-start // self._length), len(self._blocks) - 1)
        total = self._blocks[first]
        for block in self._blocks[first + 1 :]:
            total = _plus(total, block)
        return total


def _plus(first: Sums, second: Sums) -> Sums:
    return tuple(plus(mine, theirs) for mine, theirs in zip(first, second, strict=True))


def _stacked(several: list[Sums]) -> Sums:
    """Return sums of arrays with a first axis more, along which those of each lie."""
    return tuple(
        type(alike[0])(*map(np.stack, zip(*alike, strict=True)))
        for alike in zip(*several, strict=True)
    )


def _unstacked(stacked: Sums) -> list[Sums]:
    count = len(stacked[0][0]) if stacked else 0
    return [
        tuple(type(one)(*(array[index] for array in one)) for one in stacked)
        for index in range(count)
    ]
