"""A grid of cells: particles sorted by position, and the pairs among neighboring cells.

Cells form columns along the last direction, which is open. Particles are sorted by column and,
within it, by cell, so the neighbors of a cell are a few contiguous ranges. The code serves two and
three dimensions: the length of the tuples in ``Box`` fixes the dimension of a compiled kernel.
"""

from typing import Any, NamedTuple

import numpy as np

from sim.engine.compile import LANES, append_negative, assume_no_alias, exact, inlined, kernel


class Box(NamedTuple):
    """The periodic cell: ``length`` (m) per direction and its ``inverse``; both 0 for the last
    direction, which is open."""

    length: tuple[float, ...]
    inverse: tuple[float, ...]


def make_box(*length: float) -> Box:
    """Return the box that is periodic with these lengths (m) and open in one more direction."""
    return Box(
        (*(float(value) for value in length), 0.0),
        (*(1.0 / value for value in length), 0.0),
    )


@inlined
def nearest_image(difference, box, d):
    """Return the shortest periodic image of a difference along direction d; the last is open."""
    if d == len(box.length) - 1:
        return difference
    return difference - box.length[d] * np.rint(difference * box.inverse[d])


@inlined
def wrap(position, box):
    """Move every particle into the periodic cell; ``position`` is (D, N)."""
    for d in range(len(box.length) - 1):
        for i in range(position.shape[1]):
            position[d, i] -= box.length[d] * np.floor(position[d, i] * box.inverse[d])


@inlined
def extremes(values):
    """Return the smallest and the largest of some numbers."""
    smallest, largest = values[0], values[0]
    for i in range(values.size):
        smallest, largest = min(smallest, values[i]), max(largest, values[i])
    return smallest, largest


@inlined
def assign_cells(position, box, size, cells):
    """Return each particle's cell; fill ``cells`` (D,) with the number of cells per direction.

    The open direction spans the particles. A few that fly far above the others share the last
    cells, so the number of cells stays of the order of the number of particles.
    """
    dimension, particles = position.shape
    last = dimension - 1
    cell = np.zeros(particles, np.int64)
    columns = 1
    for d in range(last):
        cells[d] = max(1, int(box.length[d] / size))
        columns *= cells[d]
        for i in range(particles):
            k = int(position[d, i] * (box.inverse[d] * cells[d]))
            cell[i] = cell[i] * cells[d] + min(max(k, 0), cells[d] - 1)
    lowest, highest = extremes(position[last])
    extent = min((highest - lowest) / size, 8.0 * particles / columns + 64.0)
    cells[last] = int(extent) + 1
    for i in range(particles):
        k = int(min((position[last, i] - lowest) / size, extent))
        cell[i] = cell[i] * cells[last] + k
    return cell


@inlined
def round_up(number, size):
    """Return the smallest multiple of ``size`` that is not below ``number``."""
    return (number + size - 1) // size * size


@kernel
def sort_by_cell(cell, cells):
    """Return the particles ordered by cell and where each cell begins (a counting sort).

    ``cells`` (D,) is the number of cells per direction.
    """
    number = 1
    for d in range(cells.size):
        number *= cells[d]
    begin = np.zeros(number + 1, np.int64)
    for i in range(cell.size):
        begin[cell[i] + 1] += 1
    for c in range(number):
        begin[c + 1] += begin[c]
    order = np.empty(cell.size, np.int64)
    fill = begin.copy()
    for i in range(cell.size):
        order[fill[cell[i]]] = i
        fill[cell[i]] += 1
    return order, begin


@kernel
def reorder(array, order):
    """Sort the columns of ``array`` (K, N), or (K, 0), in place: column i becomes ``order[i]``."""
    if array.shape[1] > 0:
        for k in range(array.shape[0]):
            old = array[k].copy()
            for i in range(order.size):
                array[k, i] = old[order[i]]


@kernel
def list_columns_ahead(cells, column, out):
    """Fill ``out`` with the distinct neighbors of a column that have a larger number.

    Returns their count. With these alone each pair of columns occurs once, even in a narrow box.
    """
    count = 0
    directions = cells.size - 1
    for stencil in range(3**directions):
        rest, code, factor, neighbor = column, stencil, 1, 0
        for d in range(directions - 1, -1, -1):
            k = (rest % cells[d] + code % 3 - 1) % cells[d]
            rest //= cells[d]
            code //= 3
            neighbor += k * factor
            factor *= cells[d]
        is_listed = neighbor <= column
        for c in range(count):
            is_listed |= out[c] == neighbor
        if not is_listed:
            out[count] = neighbor
            count += 1
    return count


class Grid(NamedTuple):
    """The periodic ``box`` cut into ``cells`` (D,) per direction; ``begin`` (C + 1,) counts the
    sorted particles before each cell."""

    box: Box
    cells: np.ndarray
    begin: np.ndarray


class SortedParticles(NamedTuple):
    """Particles by cell: number i was ``order[i]`` (N,); ``place`` (D, N) and ``size`` (N,) are
    positions and radii (m)."""

    order: np.ndarray
    place: np.ndarray
    size: np.ndarray


class Part(NamedTuple):
    """One thread's part of a search: cells ``first``..``last``, with ``room`` for its pairs from
    number ``base`` on."""

    first: int
    last: int
    base: int
    room: int


class Candidates(NamedTuple):
    """Scratch of the search: ``number`` of the particles around a cell, ``gap`` (m²), ``near``."""

    number: np.ndarray
    gap: np.ndarray
    near: np.ndarray


@inlined
def _collect(number, first, last, count):
    """Append the particles ``first``..``last`` to the candidates; return the new count."""
    for n in range(last - first):
        number[np.uint64(count + n)] = first + n
    return count + last - first


@inlined
def _find_near(candidates, index, count, particles, box, skin):
    """List which of ``count`` candidates after number ``index`` are within reach plus skin of it.

    Returns their number. The gaps of a few entries after the last candidate are computed but not
    used.
    """
    position, radius = particles.place, particles.size
    i = np.uint64(candidates.number[index])
    candidates_after = count - index - 1
    for n in range(round_up(candidates_after, LANES)):
        j = np.uint64(candidates.number[np.uint64(index + 1 + n)])
        square = 0.0
        for d in range(len(box.length)):
            square += nearest_image(position[d, j] - position[d, i], box, d) ** 2
        candidates.gap[n] = square - (radius[j] + radius[i] + skin) ** 2
    near = append_negative(
        candidates.gap, candidates_after, index + 1, candidates.near, np.uint64(0)
    )
    return np.int64(near)


@inlined
def find_pairs(particles, grid, skin, part, next_list):
    """Find the pairs of sorted particles within reach plus skin whose first is in a part's cells.

    Fills ``second`` of ``next_list``, and its ``start`` and ``stop`` (N,), which delimit the pairs
    of each particle. Returns the number of pairs, or -1 as soon as room may be short.
    """
    assume_no_alias()
    count, layers = particles.size.size + LANES, grid.cells[-1]
    candidates = Candidates(np.zeros(count, np.uint32), np.zeros(count), np.zeros(count, np.uint32))
    around, columns, slot, begin = np.empty(9, np.int64), 0, part.base, grid.begin
    for cell in range(part.first, part.last):
        column, layer = cell // layers, cell % layers
        first, last = begin[cell], begin[cell + 1]
        if layer == 0 or cell == part.first:
            columns = list_columns_ahead(grid.cells, column, around)
        if first == last:
            continue
        cell_end = begin[cell + 2] if layer + 1 < layers else last
        count = _collect(candidates.number, first, cell_end, 0)
        low, high = max(layer - 1, 0), min(layer + 2, layers)
        for c in range(columns):
            floor = around[c] * layers
            count = _collect(candidates.number, begin[floor + low], begin[floor + high], count)
        for i in range(first, last):
            if slot + count > part.base + part.room:
                return -1
            next_list.start[i] = slot
            near = _find_near(candidates, i - first, count, particles, grid.box, skin)
            for n in range(near):
                next_list.second[np.uint64(slot + n)] = candidates.number[candidates.near[n]]
            slot += near
            next_list.stop[i] = slot
    return slot - part.base


OK = 0
LIST_FULL = 1
NOT_FINITE = 2
OVERLAP = 3

REASONS = {NOT_FINITE: "a position is not finite", OVERLAP: "an overlap exceeds overlap_limit"}


class BlowUp(RuntimeError):
    """The motion has become unphysical; the message is the reason.

    ``samples`` are those that the same call took before that, if any.
    """

    def __init__(self, reason: str, samples: Any = None):
        super().__init__(reason)
        self.samples = samples


def failure_reason(status: int, position: np.ndarray) -> str:
    """Return the reason for a failure after steps with this status, or an empty text."""
    if status == OK and not is_finite(position):
        status = NOT_FINITE
    return REASONS.get(status, "")


@exact
def is_finite(position):
    """True where all positions are finite."""
    bad_values = 0
    for value in position.flat:
        bad_values += not np.isfinite(value)
    return bad_values == 0
