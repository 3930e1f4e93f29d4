"""What the engine's tests share: constants, laws, drivers of single contacts, start states."""

from functools import partial
from itertools import product
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from sim.engine.boundary.belt import belt_state
from sim.engine.compile import append_negative, assume_no_alias, kernel
from sim.engine.contact.damping import SpringDamping, disk_force, spring_damping
from sim.engine.contact.friction import blank_memory, contact_force, cube_root, inverse_square_root
from sim.engine.contact.walton_braun import WaltonBraun, walton_braun
from sim.engine.dynamics.cells import LIST_FULL, OK
from sim.engine.dynamics.disks import CORRECTORS, Gear, correct, predict
from sim.engine.dynamics.team import barrier

#: The chute's spheres and the belt's mean bead, SI.
RADIUS, MASS, GRAVITY = 0.5e-3, 1.492e-6, 9.8
BEAD, BEAD_MASS, BEAD_GRAVITY = 1e-3, 1e-6, 10.0

#: Published stiffness Y (N/m) and damping (1/s) of the beads.
YOUNG = 1e3 * BEAD_GRAVITY * BEAD_MASS / BEAD
DAMPING = 50 * BEAD_GRAVITY

#: The parameters that are readings of Walton and Braun's law, and all their combinations.
VALUES = {
    "tangential_exponent": (0.0, 1 / 3, 1.0, 2.0),
    "overlap_memory": ("separation", "shrink", "reset"),
    "friction_cap": ("before", "after"),
    "sliding_direction": ("printed", "slip"),
}
READINGS = [dict(zip(VALUES, values, strict=True)) for values in product(*VALUES.values())]

#: Laws with which tests take spheres through the whole loop over steps, whose compiling takes long:
#: together they have every value but one direction of sliding, and tests/golden has the same.
LAWS = [
    {"tangential_exponent": exponent, "overlap_memory": memory, "friction_cap": cap}
    for exponent, memory, cap in (
        (1 / 3, "separation", "before"),
        (0.0, "shrink", "after"),
        (1.0, "reset", "before"),
    )
]

#: Laws of single contacts: those and the other direction. All combinations are compared with the
#: reference in long tests.
CONTACT_LAWS = [*LAWS, {"sliding_direction": "slip"}]

#: The same for beads: readings of the law and name of the integrator, two kinds of loops.
REDUCED = {"damping_mass": "reduced", "attraction": "clipped"}
BEAD_LAWS = [({}, "gear"), (REDUCED, "verlet")]


def sphere_law(**changes) -> WaltonBraun:
    """The base case of the chute, changed."""
    return walton_braun(**{"stiffness": 100.0, "restitution": 0.85, "friction": 0.4} | changes)


def bead_law(**changes) -> SpringDamping:
    """The base case of the belt, changed."""
    base = {"stiffness": YOUNG, "damping": DAMPING, "shear_damping": DAMPING}
    return spring_damping(**base | changes)


def gear(order: int):
    """What makes a corrector of some order for a time step."""
    return partial(Gear, coefficients=CORRECTORS[order])


def collision_time(law: WaltonBraun) -> float:
    """Duration (s) of a collision of two of the chute's spheres."""
    restitution = sqrt(law.loading / law.unloading)
    return 0.5 * pi * sqrt(0.5 * MASS / law.loading) * (1.0 + restitution)


def weight_components(angle: float) -> tuple[float, float, float]:
    """Gravity (m/s2) on a plane inclined by ``angle`` degrees."""
    slope = np.radians(angle)
    return float(GRAVITY * np.sin(slope)), 0.0, float(-GRAVITY * np.cos(slope))


@kernel
def cube_roots(x):
    """Cube roots (n,) of x (n,) as the law takes them."""
    roots = np.empty_like(x)
    for k in range(x.size):
        roots[k] = cube_root(x[k])
    return roots


@kernel
def inverse_square_roots(x):
    """One over the square roots (n,) of x (n,) as the laws take them."""
    roots = np.empty_like(x)
    for k in range(x.size):
        roots[k] = inverse_square_root(x[k])
    return roots


@kernel
def appended(gap, size, first, out, free):
    """Append ``first + k`` of the negative among the first ``size`` gaps to ``out``; how many."""
    return append_negative(gap, size, first, out, np.uint64(free))


@kernel
def gathered_sums(source, index, out):
    """Add ``source`` at ``index`` to ``out``, under the promise that no two arrays overlap."""
    assume_no_alias()
    for k in range(index.size):
        out[k] += source[index[k]]


@kernel
def meet(gate, rounds, rank, count):
    """Pass a gate for each round; return how often another thread was not there with this one.

    ``count`` (T,) is the round of each thread. Behind the gate of a round the others are in that
    round or already in the next.
    """
    missed = 0
    for number in range(1, rounds + 1):
        count[rank] = number
        barrier(gate)
        for other in range(count.size):
            if count[other] != number and count[other] != number + 1:
                missed += 1
    return missed


@kernel
def dissipated_energy(law, overlap):
    """Energy that the law says a contact of spheres has lost along overlaps (n,), without slip."""
    lost, memory, still = 0.0, blank_memory(law), (0.0, 0.0, 0.0)
    for k in range(overlap.size):
        approach = overlap[k] - (overlap[k - 1] if k else 0.0)
        _, _, memory, energy = contact_force(
            law, overlap[k], approach, (0.0, 0.0, 1.0), still, memory
        )
        lost += energy[0]
    return lost


@kernel
def disk_forces(law, overlap, normal, velocity, mass, inverse_partner_mass):
    """Force (n, 2) on a disk in each of n contacts; the arguments are arrays over contacts."""
    force = np.zeros((overlap.size, 2))
    for k in range(overlap.size):
        n, v = (normal[k, 0], normal[k, 1]), (velocity[k, 0], velocity[k, 1])
        fx, fz = disk_force(law, overlap[k], n, v, mass[k], inverse_partner_mass[k])
        force[k, 0] = fx
        force[k, 1] = fz
    return force


@kernel
def belt_states(belt, time):
    """Height (n,) and velocity (n, 2) of the belt at times (n,)."""
    height, velocity = np.empty(time.size), np.empty((time.size, 2))
    for k in range(time.size):
        height[k], v = belt_state(belt, time[k])
        velocity[k, 0] = v[0]
        velocity[k, 1] = v[1]
    return height, velocity


class Oscillator(NamedTuple):
    """The motion x'' = drive - stiffness x - damping x'."""

    stiffness: float
    damping: float
    drive: float = 0.0


@kernel
def damped_oscillation(integrator, taylor, oscillator, steps, corrections):
    """Advance Taylor terms (6, 2, N) of an `Oscillator` by some steps."""
    stiffness, damping, drive = oscillator
    for _ in range(steps):
        predict(integrator, taylor)
        for _ in range(corrections):
            for d in range(2):
                for i in range(taylor.shape[2]):
                    speed = taylor[1, d, i] / integrator.time_step
                    acceleration = drive - stiffness * taylor[0, d, i] - damping * speed
                    correct(integrator, taylor, d, i, acceleration)


def lattice(shape: tuple[int, ...], spacing: float, jitter: float, rng, base=0.0) -> np.ndarray:
    """Positions (N, D) on a cubic lattice, one spacing above ``base`` (m), each moved at random.

    ``jitter`` is the largest displacement per direction in spacings.
    """
    points = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    points = points.reshape(-1, len(shape)).astype(float)
    points += jitter * rng.uniform(-1, 1, points.shape)
    points[:, -1] += 1.0 + base / spacing
    return spacing * points


def rotation(rng) -> np.ndarray:
    """A random proper rotation (3, 3)."""
    frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return frame * np.linalg.det(frame)


def initial_order(columns: np.ndarray, label: np.ndarray) -> np.ndarray:
    """Columns (..., N) of sorted particles as rows (N, ...) in the order of the initial state.

    A copy that cannot be written to, lest a test believe that it changes the motion.
    """
    rows = columns.T[np.argsort(label[0])]
    rows.flags.writeable = False
    return rows


def wrapped(difference: np.ndarray, *length: float) -> np.ndarray:
    """Differences (N, D) of positions as nearest periodic images; a length of 0 is an open edge."""
    length = np.array(length)
    period = np.where(length > 0, length, np.inf)
    return difference - length * np.round(difference / period)


def pair_names(pairs, label) -> list[tuple[int, int]]:
    """The listed pairs by the labels of their partners, in the order of the list.

    The list comes sorted by the first particle, which is the lower one.
    """
    start = pairs.start
    first, second = pairs.first[: start[-1]], pairs.second[: start[-1]]
    assert (first < second).all()
    assert np.array_equal(first, np.repeat(np.arange(len(start) - 1), np.diff(start)))
    return list(zip(label[0, first].tolist(), label[0, second].tolist(), strict=True))


def listed_pairs(pairs, label) -> set[tuple[int, int]]:
    """The listed pairs by the labels of their partners, the lower one first; each comes once."""
    names = pair_names(pairs, label)
    found = {(min(name), max(name)) for name in names}
    assert len(found) == len(names)
    return found


def all_pairs(position, reach, length) -> set[tuple[int, int]]:
    """Every pair of positions (N, D) closer than its ``reach`` (N, N), from all distances."""
    first, second = np.triu_indices(len(position), 1)
    apart = wrapped(position[second] - position[first], *length)
    near = (apart**2).sum(axis=1) < reach[first, second] ** 2
    return set(zip(first[near].tolist(), second[near].tolist(), strict=True))


def run_on(motion, loop, steps: int):
    """Advance a motion, whose ``loop`` counts the steps, giving its list more room as needed."""
    target = loop.step[0] + steps
    status = LIST_FULL
    while status == LIST_FULL:
        status = motion.advance(target - loop.step[0])
        if status == LIST_FULL:
            motion.make_room()
    assert status == OK
    return motion
