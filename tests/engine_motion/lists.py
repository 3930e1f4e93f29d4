"""What the tests of the neighbor list share: gases, lists built from them, pairs by name."""

import numpy as np

from sim.engine.dynamics import neighbors
from sim.engine.dynamics.cells import OK, make_box
from sim.engine.dynamics.neighbors import empty_pair_list
from tests.engine_motion.helpers import all_pairs, compiled, listed_pairs, pair_names

refresh = compiled(neighbors.refresh)

UNIT = 1e-3

#: Numbers that a contact keeps here.
MEMORY = 7


class Gas:
    """Particles and their neighbor list; ``label`` (1, N) says where each was at the start.

    ``position`` (D, N) and ``radius`` (N,) follow the order of the list.
    """

    def __init__(self, position, radius, length, skin: float, room: int = 80):
        self.length, self.box = length, make_box(*length[:-1])
        self.position, self.radius = np.array(position.T, order="C"), radius.copy()
        self.label = np.arange(len(radius)).reshape(1, -1)
        self.pairs = empty_pair_list(radius, self.box, skin, room)
        self.memory = np.zeros((MEMORY, len(self.pairs.touching)))

    def rebuild(self) -> bool:
        """Wrap the particles and build the list anew; return whether there was room."""
        return self.refresh() == OK

    def refresh(self) -> int:
        """Do what the loop over steps does when the list no longer holds; return its status."""
        status, order = refresh(self.pairs, self.position, self.radius, self.memory)
        if status == OK:
            self.adopt(order)
        return status

    def adopt(self, order) -> None:
        """Bring radii and labels into the order of the list."""
        self.radius, self.label = self.radius[order], self.label[:, order]

    def names(self) -> list[tuple[int, int]]:
        """The listed pairs by the labels of their partners, in the order of the list."""
        return pair_names(self.pairs, self.label)

    def listed(self) -> set[tuple[int, int]]:
        """The listed pairs by label."""
        return listed_pairs(self.pairs, self.label)

    def expected(self) -> set[tuple[int, int]]:
        """Every pair within reach plus skin, from all distances."""
        place = np.argsort(self.label[0])
        radius = self.radius[place]
        reach = np.add.outer(radius, radius) + self.pairs.skin
        return all_pairs(self.position.T[place], reach, self.length)


def random_gas(rng, number: int, length, height: float, spread: float):
    """Random positions, unwrapped by up to three periods, and radii of a polydisperse gas."""
    extent = np.array([*length[:-1], height])
    position = rng.random((number, len(length))) * extent
    position[:, :-1] += rng.integers(-3, 4, (number, len(length) - 1)) * extent[:-1]
    return position, 0.5 * UNIT * rng.uniform(1 - spread, 1 + spread, number)
