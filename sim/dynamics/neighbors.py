"""Neighbor list with a skin, from a grid of cells: cost grows linearly with the particles.

The list is valid until some particle has moved by half the skin relative to the mean motion of all;
contact memory is carried over when it is rebuilt. Written once for two and three dimensions: the
length of the tuples in ``Box`` fixes the dimension when a kernel is compiled.
"""

from typing import NamedTuple

import numpy as np

from sim.compile import inlined, kernel
from sim.contact.friction import MEMORY
from sim.dynamics.status import LIST_FULL, NOT_FINITE, OK

#: Column of ``PairList.memory`` that holds the step at which the pair last touched.
STAMP = MEMORY


class Box(NamedTuple):
    """The periodic cell: ``length`` (m) per direction and its ``inverse``, both 0 where open."""

    length: tuple[float, ...]
    inverse: tuple[float, ...]


def make_box(*length: float) -> Box:
    """Return the box with these lengths (m); 0 leaves a direction open."""
    return Box(
        tuple(float(value) for value in length),
        tuple(1.0 / value if value else 0.0 for value in length),
    )


class PairList(NamedTuple):
    """Pairs within reach of each other, sorted by their first particle; always first < second.

    ``first``, ``second`` (capacity,) particles; ``reach`` (capacity,) sum of the radii (m);
    ``memory`` (capacity, 8) contact memory and the step of the last contact; ``start`` (N + 1,)
    first pair of each particle; ``anchor`` (N, D) positions at the last build; ``skin`` (m).
    """

    first: np.ndarray
    second: np.ndarray
    reach: np.ndarray
    memory: np.ndarray
    start: np.ndarray
    anchor: np.ndarray
    skin: float


def empty_pair_list(
    particles: int, dimension: int, skin: float, per_particle: int = 12
) -> PairList:
    """Return a list without pairs and with room for ``per_particle`` pairs per particle."""
    capacity = per_particle * particles + 8
    return PairList(
        first=np.zeros(capacity, np.int32),
        second=np.zeros(capacity, np.int32),
        reach=np.zeros(capacity),
        memory=np.zeros((capacity, MEMORY + 1)),
        start=np.zeros(particles + 1, np.int64),
        anchor=np.full((particles, dimension), np.nan),
        skin=skin,
    )


def grown(pairs: PairList) -> PairList:
    """Return a copy of the list with twice the room."""
    return pairs._replace(
        first=np.concatenate([pairs.first, np.zeros_like(pairs.first)]),
        second=np.concatenate([pairs.second, np.zeros_like(pairs.second)]),
        reach=np.concatenate([pairs.reach, np.zeros_like(pairs.reach)]),
        memory=np.concatenate([pairs.memory, np.zeros_like(pairs.memory)]),
    )


@inlined
def nearest_image(difference, box, d):
    """Return the shortest periodic image of a difference along direction d (open: itself)."""
    return difference - box.length[d] * np.rint(difference * box.inverse[d])


@kernel
def wrap(position, box):
    """Move every particle into the periodic cell."""
    for d in range(len(box.length)):
        for i in range(position.shape[0]):
            position[i, d] -= box.length[d] * np.floor(position[i, d] * box.inverse[d])


@kernel
def _grid(position, box, size):
    """Return the number of cells per direction and each particle's cell.

    Open directions span the particles; a few that fly far above the others share the last cells,
    so that the number of cells stays of the order of the number of particles.
    """
    particles, dimension = position.shape
    origin = np.zeros(dimension)
    cells = np.ones(dimension, np.int64)
    width = np.full(dimension, size)
    total = 1
    for d in range(dimension):
        if box.length[d] > 0.0:
            cells[d] = max(1, int(box.length[d] / size))
            width[d] = box.length[d] / cells[d]
            total *= cells[d]
    for d in range(dimension):
        if box.length[d] == 0.0:
            origin[d] = position[:, d].min()
            extent = min((position[:, d].max() - origin[d]) / size, 8.0 * particles / total + 64.0)
            cells[d] = int(extent) + 1
    cell = np.empty(particles, np.int64)
    for i in range(particles):
        index = 0
        for d in range(dimension):
            k = int(min((position[i, d] - origin[d]) / width[d], cells[d] - 1.0))
            index = index * cells[d] + max(k, 0)
        cell[i] = index
    return cells, cell


@kernel
def _sorted_by_cell(cell, number):
    """Return the particles ordered by cell and where each cell begins (a counting sort)."""
    begin = np.zeros(number + 1, np.int64)
    for i in range(cell.size):
        begin[cell[i] + 1] += 1
    for c in range(number):
        begin[c + 1] += begin[c]
    order = np.empty(cell.size, np.int64)
    fill = begin[:-1].copy()
    for i in range(cell.size):
        order[fill[cell[i]]] = i
        fill[cell[i]] += 1
    return order, begin


@kernel
def _stencil(box, cells, index, out):
    """Fill ``out`` with the distinct cells around (and including) a cell; return how many."""
    dimension = cells.size
    count = 1
    out[0] = 0
    remainder = index
    coordinate = np.empty(dimension, np.int64)
    for d in range(dimension - 1, -1, -1):
        coordinate[d] = remainder % cells[d]
        remainder //= cells[d]
    for d in range(dimension):
        low = -1 if cells[d] > 2 else 0
        high = 1 if cells[d] > 1 else 0
        periodic = box.length[d] > 0.0
        if not periodic:
            low, high = -1, 1
        written = 0
        previous = out[:count].copy()
        for base in previous:
            for offset in range(low, high + 1):
                k = coordinate[d] + offset
                if periodic:
                    k %= cells[d]
                elif k < 0 or k >= cells[d]:
                    continue
                out[written] = base * cells[d] + k
                written += 1
        count = written
    return count


@kernel
def _find_pairs(pairs, position, radius, box, second, reach, start):
    """Fill ``second``, ``reach`` and ``start`` with all pairs within reach plus skin.

    Returns False as soon as there is no room for another pair.
    """
    dimension = len(box.length)
    cells, cell = _grid(position, box, 2.0 * radius.max() + pairs.skin)
    order, begin = _sorted_by_cell(cell, cells.prod())
    around = np.empty(3**dimension, np.int64)
    known, size = -1, 0
    slot = 0
    for i in range(cell.size):
        start[i] = slot
        if cell[i] != known:
            known = cell[i]
            size = _stencil(box, cells, known, around)
        for s in range(size):
            for k in range(begin[around[s]], begin[around[s] + 1]):
                j = order[k]
                if j <= i:
                    continue
                square = 0.0
                for d in range(dimension):
                    square += nearest_image(position[j, d] - position[i, d], box, d) ** 2
                contact = radius[i] + radius[j]
                if square < (contact + pairs.skin) ** 2:
                    if slot == second.size:
                        return False
                    second[slot] = j
                    reach[slot] = contact
                    slot += 1
    start[cell.size] = slot
    return True


@kernel
def _carried_over(pairs, start, second, step):
    """Return the memory of the new pairs: of those that touched at ``step`` the old one."""
    memory = np.zeros((start[-1], MEMORY + 1))
    memory[:, STAMP] = -1.0
    for i in range(start.size - 1):
        for old in range(pairs.start[i], pairs.start[i + 1]):
            if pairs.memory[old, STAMP] == step:
                for new in range(start[i], start[i + 1]):
                    if second[new] == pairs.second[old]:
                        memory[new] = pairs.memory[old]
    return memory


@kernel
def rebuild(pairs, position, radius, box, step):
    """Rebuild the list for the present positions; ``step`` is that of the last forces.

    Returns False, and leaves the list as it was, when it has no room for all pairs.
    """
    second = np.empty_like(pairs.second)
    reach = np.empty_like(pairs.reach)
    start = np.empty_like(pairs.start)
    if not _find_pairs(pairs, position, radius, box, second, reach, start):
        return False
    number = start[-1]
    pairs.memory[:number] = _carried_over(pairs, start, second, step)
    pairs.second[:number] = second[:number]
    pairs.reach[:number] = reach[:number]
    pairs.start[:] = start
    pairs.anchor[:] = position
    for i in range(start.size - 1):
        pairs.first[start[i] : start[i + 1]] = i
    return True


@kernel
def refresh(pairs, position, radius, box, loop):
    """Wrap the particles and rebuild the list; return a status.

    ``loop`` is the state of a loop over time steps: its ``step`` is that of the last forces, and
    its ``drift`` and ``valid`` start anew with the list.
    """
    if not np.isfinite(position).all():
        return NOT_FINITE
    wrap(position, box)
    if not rebuild(pairs, position, radius, box, loop.step[0]):
        return LIST_FULL
    loop.drift[:] = 0.0
    loop.valid[0] = True
    return OK
