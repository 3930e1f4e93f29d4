"""Random initial positions without overlaps, by random sequential addition."""

from itertools import product
from typing import NamedTuple

import numpy as np

from sim.engine.compile import inlined, kernel
from sim.engine.dynamics.cells import Box, nearest_image

#: Offsets to the neighbor cells, the nearest first: there a trial most often fails.
STENCIL = {
    dimension: np.array(
        sorted(product((0, -1, 1), repeat=dimension), key=lambda offset: np.abs(offset).sum())
    )
    for dimension in (2, 3)
}

#: Trials per particle before giving up; below a packing fraction of 0.35 a few dozen are enough.
MAX_TRIALS = 20_000


class Packing(NamedTuple):
    """The particles that have positions so far, as linked lists by cell.

    ``position`` (N, D) and ``radius`` (N,) of all; ``cells`` (D,) per direction, of ``size`` (m)
    along the open one; ``first`` (C,) particle in each cell and the ``next`` (N,) behind each, -1
    for none; ``stencil`` (S, D), the offsets to the neighbors of a cell.
    """

    position: np.ndarray
    radius: np.ndarray
    box: Box
    cells: np.ndarray
    size: float
    first: np.ndarray
    next: np.ndarray
    stencil: np.ndarray


def _empty_packing(box: Box, height: float, radius: np.ndarray) -> Packing:
    dimension, number = len(box.length), len(radius)
    size = float(2.0 * radius.max())
    extent = np.array([*box.length[:-1], height])
    cells = np.maximum(1, (extent / size).astype(np.int64))
    cells[-1] = int(height / size) + 2
    position, first, following = (
        np.zeros((number, dimension)),
        np.full(cells.prod(), -1),
        np.full(number, -1),
    )
    return Packing(position, radius, box, cells, size, first, following, STENCIL[dimension])


def random_packing(box: Box, height: float, radius: np.ndarray, rng) -> np.ndarray:
    """Return random positions (N, D) of spheres or disks that do not overlap.

    The last direction is the open one: centres lie between one radius and one radius plus
    ``height`` (m) above zero. Raises ``ValueError`` when the particles do not fit.
    """
    number, extent = len(radius), np.array([*box.length[:-1], height])
    packing = _empty_packing(box, height, radius)
    count, trials = 0, 0
    while count < number:
        if trials > MAX_TRIALS * number:
            raise ValueError(f"only {count} of {number} particles fit without overlap")
        candidates = rng.random((max(64, 4 * (number - count)), len(extent))) * extent
        trials += len(candidates)
        count = _insert(candidates, count, packing)
    return packing.position


@kernel
def _insert(candidates, count, packing):
    """Add the candidates that overlap no earlier particle; return the number placed so far."""
    box, cells = packing.box, packing.cells
    dimension = len(box.length)
    home = np.zeros(dimension, np.int64)
    for c in range(candidates.shape[0]):
        if count == packing.radius.size:
            break
        trial = candidates[c]
        trial[dimension - 1] += packing.radius[count]
        for d in range(dimension):
            width = box.length[d] / cells[d] if box.length[d] > 0.0 else packing.size
            home[d] = min(int(trial[d] / width), cells[d] - 1)
        if _is_free(trial, home, packing.radius[count], packing):
            index = 0
            for d in range(dimension):
                packing.position[count, d] = trial[d]
                index = index * cells[d] + home[d]
            packing.next[count] = packing.first[index]
            packing.first[index] = count
            count += 1
    return count


@inlined
def _is_free(trial, home, radius, packing):
    """True where a trial position overlaps no particle in the cells around its home cell."""
    box, cells = packing.box, packing.cells
    dimension = len(box.length)
    for s in range(packing.stencil.shape[0]):
        index, inside = 0, True
        for d in range(dimension):
            k = home[d] + packing.stencil[s, d]
            if box.length[d] > 0.0:
                k += cells[d] if k < 0 else (-cells[d] if k >= cells[d] else 0)
            inside &= 0 <= k < cells[d]
            index = index * cells[d] + k
        other = packing.first[index] if inside else -1
        while other >= 0:
            square = 0.0
            for d in range(dimension):
                square += nearest_image(trial[d] - packing.position[other, d], box, d) ** 2
            if square < (radius + packing.radius[other]) ** 2:
                return False
            other = packing.next[other]
    return True
