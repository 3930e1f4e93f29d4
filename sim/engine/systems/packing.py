"""Random initial positions without overlaps, by random sequential addition."""

from itertools import product

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


def random_packing(box: Box, height: float, radius: np.ndarray, rng) -> np.ndarray:
    """Return random positions (N, D) of spheres or disks that do not overlap.

    The last direction is the open one: centres lie between one radius and one radius plus
    ``height`` (m) above zero. Raises ``ValueError`` when the particles do not fit.
    """
    dimension = len(box.length)
    number = len(radius)
    extent = np.array([*box.length[:-1], height])
    size = 2.0 * radius.max()
    cells = np.maximum(1, (extent / size).astype(np.int64))
    cells[-1] = int(height / size) + 2
    position = np.zeros((number, dimension))
    stencil = STENCIL[dimension]
    head = np.full(cells.prod(), -1)
    following = np.full(number, -1)
    placed, trials = 0, 0
    while placed < number:
        if trials > MAX_TRIALS * number:
            raise ValueError(f"only {placed} of {number} particles fit without overlap")
        candidates = rng.random((max(64, 4 * (number - placed)), dimension)) * extent
        trials += len(candidates)
        placed = _insert(
            candidates, placed, position, radius, box, cells, size, stencil, head, following
        )
    return position


@kernel
def _insert(candidates, placed, position, radius, box, cells, size, stencil, head, following):
    """Add the candidates that overlap no earlier particle; return how many are placed by now."""
    dimension = len(box.length)
    home = np.zeros(dimension, np.int64)
    for c in range(candidates.shape[0]):
        if placed == radius.size:
            break
        trial = candidates[c]
        trial[dimension - 1] += radius[placed]
        for d in range(dimension):
            width = box.length[d] / cells[d] if box.length[d] > 0.0 else size
            home[d] = min(int(trial[d] / width), cells[d] - 1)
        if _is_free(trial, home, placed, position, radius, box, cells, stencil, head, following):
            position[placed] = trial
            index = 0
            for d in range(dimension):
                index = index * cells[d] + home[d]
            following[placed] = head[index]
            head[index] = placed
            placed += 1
    return placed


@inlined
def _is_free(trial, home, placed, position, radius, box, cells, stencil, head, following):
    """Return whether the trial position overlaps no placed particle in the cells around it."""
    dimension = len(box.length)
    for s in range(stencil.shape[0]):
        index, inside = 0, True
        for d in range(dimension):
            k = home[d] + stencil[s, d]
            if box.length[d] > 0.0:
                k += cells[d] if k < 0 else (-cells[d] if k >= cells[d] else 0)
            inside &= 0 <= k < cells[d]
            index = index * cells[d] + k
        other = head[index] if inside else -1
        while other >= 0:
            square = 0.0
            for d in range(dimension):
                square += nearest_image(trial[d] - position[other, d], box, d) ** 2
            if square < (radius[placed] + radius[other]) ** 2:
                return False
            other = following[other]
    return True
