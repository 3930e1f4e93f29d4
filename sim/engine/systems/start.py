"""Initial states: given or random ones, a layer above the plane, a bed above the belt."""

from collections.abc import Callable, Hashable
from copy import deepcopy
from itertools import product
from math import pi, radians, tan
from typing import Any, NamedTuple

import numpy as np

from sim.base.errors import InputError
from sim.engine.boundary.belt import Belt, belt_height
from sim.engine.boundary.motion import motion_of
from sim.engine.compile import inlined, kernel
from sim.engine.dynamics.cells import Box, make_box, nearest_image
from sim.engine.dynamics.disks import CORRECTORS, Gear, Verlet
from sim.engine.states import flatten
from sim.engine.systems.packed_base import packed_base
from sim.parameters import BeltParameters, point_id
from sim.parameters.given import given_particles, overlapping_pair
from sim.parameters.images import TOP, wider_cell
from sim.parameters.spheres import SphereParameters

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


class Layer(NamedTuple):
    """Particles: ``position`` and ``velocity`` (N, D), ``radius`` and ``mass`` (N,), SI.

    Glued spheres come last; they have no mass. ``height`` (m) is that of the filled region, and
    ``spin`` (N, 3) the angular velocity (1/s) of particles that rotate.
    """

    position: np.ndarray
    velocity: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    height: float
    spin: np.ndarray | None = None


def initial_layer(p: SphereParameters, box: Box, replicate: int) -> Layer:
    """Return the initial state of a replicate of spheres, or of discs in the plane y = 0.

    Raises ``ValueError`` when the particles do not fit, and `InputError` where the largest of few
    particles is so large that it needs a wider cell, or a given one overlaps a glued one too much.
    """
    if p.initial_state:
        return _given_layer(p, box, replicate)
    rng = np.random.default_rng([p.seed, replicate])
    dimension, solid, root = (2, 4.0, np.sqrt) if p.is_flat else (3, 6.0, np.cbrt)
    height = p.depth * pi / solid * p.diameter / p.initial_packing
    spread, size = p.diameter_spread, np.ones(p.particles)
    if spread > 0.0:
        size = rng.uniform(1.0 - spread, 1.0 + spread, p.particles)
    # The flow weighs as much as one of equal particles.
    size /= root((size**dimension).mean())
    narrow = p.cell if p.is_flat else min(p.cell, p.breadth)
    reach = p.law_reach / p.diameter
    if allowed := wider_cell(narrow, float(size.max()), p.bumps, reach):
        raise InputError.of_value(point_id(p), "cell", narrow, allowed)
    radius = 0.5 * p.diameter * size
    position = random_packing(_cell_of(p, box), height, radius, rng)
    velocity = _random_velocities(p, position.shape, rng)
    mass = p.mass * size**dimension
    if p.initial_height:
        position[:, -1] += p.initial_height * p.diameter - (position[:, -1] - radius).min()
    mobile = Layer(_in_space(p, position), _in_space(p, velocity), radius, mass, height)
    if not p.bumps:
        return mobile
    diameter = p.bumps * p.diameter
    top = np.array([0.0, 0.0, TOP * diameter if p.bump_arrangement == "packing" else diameter])
    raised = mobile._replace(position=mobile.position + top, height=height + top[2])
    return _with_glued(raised, p, box, replicate)


def _cell_of(p: SphereParameters, box: Box) -> Box:
    """Return the periodic cell of a point in its own dimensions, two of discs."""
    return make_box(box.length[0]) if p.is_flat else box


def _in_space(p: SphereParameters, vectors: np.ndarray) -> np.ndarray:
    """Return vectors (N, D) of a point as those of spheres (N, 3)."""
    return np.insert(vectors, 1, 0.0, axis=1) if p.is_flat else vectors


def _random_velocities(p: SphereParameters, shape: tuple[int, ...], rng) -> np.ndarray:
    """Return random velocities (N, D) about the common one, m/s."""
    velocity = rng.normal(0.0, p.initial_agitation * p.velocity_unit / shape[1] ** 0.5, shape)
    velocity -= velocity.mean(axis=0)
    velocity[:, 0] += p.initial_velocity * p.velocity_unit
    if p.initial_normal_velocity:
        velocity[:, -1] += p.initial_normal_velocity * p.velocity_unit
    return velocity


def _given_layer(p: SphereParameters, box: Box, replicate: int) -> Layer:
    given = given_particles(p)
    common = np.array([p.initial_velocity, 0.0, p.initial_normal_velocity]) * p.velocity_unit
    top = float((given.position[:, 2] + given.radius).max())
    layer = Layer(
        given.position, given.velocity + common, given.radius, given.mass, top, given.spin
    )
    if not p.bumps:
        return layer
    layer = _with_glued(layer, p, box, replicate)
    if pair := overlapping_pair(layer.position, layer.radius, p, movable=len(given.radius)):
        allowed = f"a state that overlaps no glued particle as number {min(pair) + 1} does"
        raise InputError.of_value(point_id(p), "initial_state", p.initial_state, allowed)
    return layer


def _bump_positions(p: SphereParameters, box: Box, replicate: int) -> np.ndarray:
    """Return positions of the particles that are glued to the plane."""
    radius = p.bumps * p.diameter / 2
    rng = np.random.default_rng([p.seed, replicate, 1])
    if p.bump_arrangement == "packing":
        return packed_base(p.cell / p.bumps, p.breadth / p.bumps, 2 * radius, rng)
    if p.bump_arrangement == "random":
        return random_packing(box, 0.0, np.full(p.glued_particles, radius), rng)
    sides = zip(box.length, p.bump_rows, strict=False)
    grid = np.meshgrid(*(side * ((np.arange(n) + 0.5) / n) for side, n in sides), [radius])
    return np.stack([axis.ravel() for axis in grid], axis=1)


def _with_glued(mobile: Layer, p: SphereParameters, box: Box, replicate: int) -> Layer:
    """Return mobile particles followed by those that are glued to the plane."""
    glued = _in_space(p, _bump_positions(p, _cell_of(p, box), replicate))
    still, number = np.zeros_like(glued), len(glued)
    return mobile._replace(
        position=np.concatenate([mobile.position, glued]),
        velocity=np.concatenate([mobile.velocity, still]),
        radius=np.concatenate([mobile.radius, np.full(number, p.bumps * p.diameter / 2)]),
        mass=np.concatenate([mobile.mass, np.zeros(number)]),
        spin=None if mobile.spin is None else np.concatenate([mobile.spin, still]),
    )


#: Area fraction of the random initial state; random sequential addition saturates near 0.55.
INITIAL_PACKING = 0.3

#: Stages before the first sample, and that of the samples.
FALLING, PRIOR_SHAKING, SHAKING = "falling", "shaken before", ""


def initial_bed(p: BeltParameters, box: Box, replicate: int) -> Layer:
    """Return beads at rest that overlap neither each other nor belt nor obstacle, or given ones."""
    if p.initial_state:
        given = given_particles(p)
        place, velocity = given.position[:, ::2], given.velocity[:, ::2]
        top = float((place[:, 1] + given.radius).max())
        return Layer(place, velocity, given.radius, given.mass, top)
    rng = np.random.default_rng([p.seed, replicate])
    spread = p.diameter_spread * p.diameter
    diameter = rng.uniform(p.diameter - spread, p.diameter + spread, p.beads)
    mass = p.mass * (diameter / p.diameter) ** 2
    layer = (pi / 4.0 * diameter**2).sum() / (INITIAL_PACKING * box.length[0])
    height = max(layer, p.diameter + spread)
    position = random_packing(box, height, 0.5 * diameter, rng)
    position[:, 1] += _lift(p)
    return Layer(position, np.zeros_like(position), 0.5 * diameter, mass, height)


def _lift(p: BeltParameters) -> float:
    """Return how far (m) to raise the beads so that none overlaps the belt or the obstacle."""
    belt = vibration(p, 0.0)
    lift = belt_height(belt, 0.0) + belt.surface
    if p.obstacle > 0.0:
        lift = max(lift, (p.amplitude + 0.5 * p.obstacle) * p.diameter)
    return lift


def vibration(p: BeltParameters, frequency: float) -> Belt:
    """Return the belt vibrating at a frequency (Hz), or at rest in its initial phase."""
    amplitude = p.amplitude * p.diameter
    # Not tan(90°), which rounds to a finite number: a vertical vibration has A_x = 0. So has a
    # belt at rest, on which beds settle alike at all angles.
    is_along = frequency > 0.0 and p.vibration_angle < 90.0
    slope = tan(radians(p.vibration_angle)) if is_along else np.inf
    surface = 0.5 * p.diameter if p.belt_ghost == "centred" else 0.0
    return Belt(
        amplitude / slope,
        amplitude,
        2.0 * pi * frequency,
        radians(p.phase),
        surface,
        inverse_mass=1.0 / p.mass if p.ghost_mass == "mean" else 0.0,
        motion=motion_of(p),
    )


class Stage(NamedTuple):
    """How the bed moves in a stage: the ``belt``, the ``integrator``, the words for messages."""

    belt: Belt
    integrator: Gear | Verlet
    words: str


def make_stages(
    p: BeltParameters, settling_step: float, time_step: float, cycle_steps: int
) -> dict[str, Stage]:
    """Return the stages of a point: steps (s) of settling and shaking, steps in a cycle."""
    stages = {
        FALLING: _stage(p, 0.0, settling_step, "while the bed settles"),
        SHAKING: _stage(p, p.frequency, time_step, "of the shaking"),
    }
    if frequency := p.prior_frequency:
        words, step = "of the shaking at the prior frequency", 1.0 / (frequency * cycle_steps)
        stages[PRIOR_SHAKING] = _stage(p, frequency, step, words)
    return stages


def _stage(p: BeltParameters, frequency: float, time_step: float, words: str) -> Stage:
    step = float(time_step)
    verlet = p.integrator == "verlet"
    integrator = Verlet(step) if verlet else Gear(step, CORRECTORS[p.corrector_order])
    return Stage(vibration(p, frequency), integrator, words)


#: Most memory (bytes) of the beds in `beds`; the one that was last asked for the longest time ago
#: goes first.
ROOM = 16_000_000

#: Beds that have come to rest in this process, by all that their settling was given: points that
#: differ in the shaking alone share one. None outlives the code that settled it.
beds: dict[tuple[Any, ...], Any] = {}


def settle_once(kind: Hashable, given: Any, settle: Callable[[], Any]) -> Any:
    """Return what ``settle`` returns, without calling it where an equal bed has settled before.

    It returns the settled bed, nested tuples of arrays and numbers; its exceptions are passed on.
    ``kind`` selects the compiled code, and ``given`` is all else that it reads, nested tuples as
    well.
    """
    values = flatten(given).values()
    key = kind, *(one.tobytes() if isinstance(one, np.ndarray) else repr(one) for one in values)
    bed = beds.pop(key, None) or settle()
    beds[key] = deepcopy(bed)
    while sum(map(_size, list(beds.values()))) > ROOM:
        beds.pop(next(iter(list(beds))), None)
    return bed


def _size(bed: Any) -> int:
    """Return the bytes of the arrays of a bed."""
    return sum(np.asarray(value).nbytes for value in flatten(bed).values())
