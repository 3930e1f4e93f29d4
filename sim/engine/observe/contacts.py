"""Stress profiles of a flow of spheres, and slip and dissipation of its contacts by height.

The momentum of a sphere is located at its centre z. Relative to a slice [a, a + Δz), the share
h = (z - a)/Δz, clipped to [0, 1], of the momentum is above the middle of the slice. A step of
leap-frog is a drift from z to z' and a kick there, so it changes the momentum above, Σ m v h, by
exactly

    Σ m v (h(z') - h(z)) + Δt Σ (F + m g) h(z').

The first sum is the momentum that spheres carry upwards; each sphere contributes to the slices that
its path crosses. The second sum has the forces of contacts, each in the slices that its branch
crosses, and the weight above. Both are distributed by length, so both are means over the slice of
the flux through its planes. The stresses of a sample therefore add up to the weight above, except
for the gain of the momentum above in that step.
"""

from typing import NamedTuple

import numpy as np

from sim.engine.compile import by_type, inlined, kernel
from sim.engine.contact.friction import blank_memory, recall
from sim.engine.contact.functions import gap_to_plane, law_between, law_on_plane, reach_of
from sim.engine.dynamics.spheres import (
    DEPTH,
    FX,
    LOSS,
    NX,
    ROWS,
    STRIDE,
    SX,
    WORK,
    Meeting,
    apply_law,
    nearest_separation,
    write_approach,
)
from sim.engine.observe.samples import ContactList, append_contact

#: Components of the stress that are not zero by symmetry, and their number; the last is the force
#: along x through planes of constant z.
XX, YY, ZZ, XZ = range(4)
COMPONENTS = 4

#: A contact slides where its friction is this close to its limit, relative to the limit.
SLIDES = 1e-6


class Stress(NamedTuple):
    """Sums over samples, one row per slice of H.

    ``samples`` (1,) number of samples; ``branches`` (H, 4) force times branch (J) of the contacts.
    For the spheres in the slice: ``mass`` (H,) (kg); ``momentum`` (H, 3) (kg m/s); ``relative``
    (H,) momentum along x relative to the mean velocity of all spheres (kg m/s); ``flux`` (H, 4)
    momentum times velocity (J), where the square along x is that of the relative velocity.
    ``above`` (H,) mass above the middle of the slice (kg).
    """

    samples: np.ndarray
    branches: np.ndarray
    mass: np.ndarray
    momentum: np.ndarray
    relative: np.ndarray
    flux: np.ndarray
    above: np.ndarray

    def contact(self, volume: float) -> np.ndarray:
        """Return the stress (Pa) of the contacts in slices of a volume (m³), (H, 4)."""
        return self.branches / (volume * self.samples[0])

    def kinetic(self, volume: float) -> np.ndarray:
        """Return the stress (Pa) of the motion about the mean profile, (H, 4).

        The mean is taken over all samples: a slice that moves up and down as a whole does transport
        momentum, and with any other mean the balance would not close.
        """
        px, py, pz = self.momentum.T
        squares = np.stack([self.relative**2, py * py, pz * pz, px * pz], axis=1)
        mean = np.zeros_like(squares)
        np.divide(squares, self.mass[:, None], out=mean, where=self.mass[:, None] > 0.0)
        stress = (self.flux - mean) / (volume * self.samples[0])
        stress[:, XZ] *= -1.0
        return stress


class Slip(NamedTuple):
    """Sums over samples, one row per slice; each contact counts in the slice at its height.

    ``contacts`` (H,) number of contacts with a force; ``sliding`` (H,) number of sliding contacts;
    ``speed`` (H,) their slip velocity (m/s). Over all contacts: ``lost`` (H,) power dissipated by
    normal forces (W); ``rubbed`` (H,) power against friction (W), including the energy stored in
    tangential springs.
    """

    contacts: np.ndarray
    sliding: np.ndarray
    speed: np.ndarray
    lost: np.ndarray
    rubbed: np.ndarray


class ContactSums(NamedTuple):
    """Sums of the stress by height, and of the slip of contacts."""

    stress: Stress
    slip: Slip


class Sampling(NamedTuple):
    """Conditions of a sample: ``step`` number of the last step; ``slice`` height of a slice (m);
    ``time_step`` (s); ``friction`` coefficients between spheres and with the plane."""

    step: int
    slice: float
    time_step: float
    friction: tuple[float, float]


def no_stress(slices: int) -> Stress:
    """Return sums of zero."""
    tensors = [np.zeros((slices, COMPONENTS)) for _ in range(2)]
    return Stress(
        samples=np.zeros(1),
        branches=tensors[0],
        mass=np.zeros(slices),
        momentum=np.zeros((slices, 3)),
        relative=np.zeros(slices),
        flux=tensors[1],
        above=np.zeros(slices),
    )


def no_slip(slices: int) -> Slip:
    """Return sums of zero."""
    return Slip(*(np.zeros(slices) for _ in Slip._fields))


@inlined
def _share_in(s, low, high, slice_height):
    """Return the share of the interval from ``low`` to ``high`` (m) that lies in slice s."""
    if int(np.floor(low / slice_height)) == int(np.floor(high / slice_height)):
        return 1.0
    inside = min(high, (s + 1) * slice_height) - max(low, s * slice_height)
    return max(0.0, inside) / (high - low)


@inlined
def _slices_of(low, high, slice_height, slices):
    """Return the range of slices that the interval from ``low`` to ``high`` (m) crosses."""
    first = max(0, int(np.floor(low / slice_height)))
    return range(first, min(slices, int(np.floor(high / slice_height)) + 1))


@inlined
def _normal_and_slip(rows, time_step):
    """Return normal and slip velocity (m/s) of the contact in column 0, before a law is applied."""
    sx, sy, sz = rows[SX * STRIDE], rows[(SX + 1) * STRIDE], rows[(SX + 2) * STRIDE]
    normal = (rows[NX * STRIDE], rows[(NX + 1) * STRIDE], rows[(NX + 2) * STRIDE])
    return normal, (sx * sx + sy * sy + sz * sz) ** 0.5 / time_step


@by_type
def record_contact(collector, sampling, rows, contact):
    """Add a contact with the force in column 0 to a ``ContactList`` or to ``ContactSums``.

    ``contact``: numbers of the partners; branch (x, y, z) (m) from j to i, height of i and height
    of the contact (m); normal; slip velocity (m/s) and coefficient of friction.
    """
    return _list_contact if collector.instance_class is ContactList else _add_contact


def _list_contact(collector, sampling, rows, contact):
    fx, fy, fz = rows[FX * STRIDE], rows[(FX + 1) * STRIDE], rows[(FX + 2) * STRIDE]
    if rows[DEPTH * STRIDE] > 0.0 or fx != 0.0 or fy != 0.0 or fz != 0.0:
        append_contact(collector, contact[0], (fx, fy, fz))


def _add_contact(collector, sampling, rows, contact):
    stress, slip = collector.stress, collector.slip
    _, ((bx, by, bz), top, at), normal, (speed, friction) = contact
    fx, fy, fz = rows[FX * STRIDE], rows[(FX + 1) * STRIDE], rows[(FX + 2) * STRIDE]
    low, high = min(top, top - bz), max(top, top - bz)
    for s in _slices_of(low, high, sampling.slice, stress.mass.size):
        share = _share_in(s, low, high, sampling.slice)
        stress.branches[s, XX] += fx * bx * share
        stress.branches[s, YY] += fy * by * share
        stress.branches[s, ZZ] += fz * bz * share
        stress.branches[s, XZ] -= fx * bz * share
    pressed = -(fx * normal[0] + fy * normal[1] + fz * normal[2])
    for s in _slices_of(at, at, sampling.slice, stress.mass.size):
        slip.lost[s] += rows[LOSS * STRIDE] / sampling.time_step
        slip.rubbed[s] += rows[WORK * STRIDE] / sampling.time_step
        if pressed > 0.0:
            tx, ty = fx + pressed * normal[0], fy + pressed * normal[1]
            tz = fz + pressed * normal[2]
            slides = (tx * tx + ty * ty + tz * tz) ** 0.5 >= (1.0 - SLIDES) * friction * pressed
            slip.contacts[s] += 1.0
            slip.sliding[s] += 1.0 if slides else 0.0
            slip.speed[s] += speed if slides else 0.0


@inlined
def _add_spheres(stress, spheres, sampling):
    """Add the momentum flux of the spheres from their last positions, and the mass above slices."""
    x, v, slices, height = spheres.position, spheres.velocity, stress.mass.size, sampling.slice
    total, along = 0.0, 0.0
    for i in range(spheres.mass.size):
        total += spheres.mass[i]
        along += spheres.mass[i] * v[0, i]
    whole = np.zeros(slices + 1)
    for i in range(spheres.mass.size):
        mass, vx, vy, vz = spheres.mass[i], v[0, i], v[1, i], v[2, i]
        before = x[2, i] - vz * sampling.time_step
        low, high, relative = min(before, x[2, i]), max(before, x[2, i]), vx - along / total
        for s in _slices_of(low, high, height, slices):
            part = mass * _share_in(s, low, high, height)
            stress.mass[s] += part
            stress.momentum[s, 0] += part * vx
            stress.momentum[s, 1] += part * vy
            stress.momentum[s, 2] += part * vz
            stress.relative[s] += part * relative
            stress.flux[s, XX] += part * relative * relative
            stress.flux[s, YY] += part * vy * vy
            stress.flux[s, ZZ] += part * vz * vz
            stress.flux[s, XZ] += part * vx * vz
        top = min(slices, max(0, int(np.floor(x[2, i] / height))))
        whole[top] += mass
        if top < slices:
            stress.above[top] += mass * max(0.0, x[2, i] / height - top)
    for s in range(slices - 1, -1, -1):
        stress.above[s] += whole[s + 1]
        whole[s] += whole[s + 1]


@kernel
def add_contacts(sums, spheres, contacts, sampling):
    """Add the present state to sums of stress and slip, see `_visit_contacts`."""
    sums.stress.samples[0] += 1.0
    _visit_contacts(sums, spheres, contacts, sampling)
    _add_spheres(sums.stress, spheres, sampling)


@kernel
def list_contacts(contact_list, spheres, contacts, sampling):
    """Write the contacts of the present state into a ``ContactList``, see `_visit_contacts`."""
    _visit_contacts(contact_list, spheres, contacts, sampling)


@inlined
def _visit_contacts(collector, spheres, contacts, sampling):
    """Call ``record_contact`` for each contact of the present state.

    The forces are those at the beginning of the next step, for all laws. ``contacts`` are those of
    the loop over steps. Where the pair list no longer holds, contacts that began in the last step
    are missing.
    """
    x, v, w, step = spheres.position, spheres.velocity, spheres.rim, sampling.time_step
    law, plane_law = contacts.laws
    friction, plane_friction = sampling.friction
    pairs, slot = contacts.pairs, contacts.plane.slot
    memory = contacts.memory[sampling.step % 2]
    plane_memory = contacts.plane.memory[sampling.step % 2]
    rows, new, reach = np.zeros(ROWS * STRIDE), blank_memory(law), contacts.bond.reach
    for p in range(pairs.start[-1]):
        i, j = pairs.first[p], pairs.second[p]
        dx, dy, dz = nearest_separation(x, pairs.box, i, j)
        fixed = spheres.mass[i] + spheres.mass[j] == 0.0
        most = pairs.reach[p] + reach_of(law, reach)
        if fixed or dx * dx + dy * dy + dz * dz >= most * most:
            continue
        velocity = (v[0, j] - v[0, i], v[1, j] - v[1, i], v[2, j] - v[2, i])
        rim = (w[0, j] + w[0, i], w[1, j] + w[1, i], w[2, j] + w[2, i])
        write_approach(rows, 0, Meeting((dx, dy, dz), velocity, rim, pairs.reach[p]), step)
        normal, speed = _normal_and_slip(rows, step)
        pair_law = law_between(law, spheres, pairs, p, step)
        apply_law(pair_law, rows, 0, recall(new, memory, pairs.slot[p]))
        at = x[2, i] + (spheres.radius[i] - 0.5 * rows[DEPTH * STRIDE]) * normal[2]
        geometry = (-dx, -dy, -dz), x[2, i], at
        contact = (spheres.label[0, i], spheres.label[0, j]), geometry, normal, (speed, friction)
        record_contact(collector, sampling, rows, contact)
    for i in range(spheres.mass.size):
        if spheres.mass[i] == 0.0 or gap_to_plane(plane_law, spheres, i, reach) >= 0.0:
            continue
        velocity, rim = (-v[0, i], -v[1, i], -v[2, i]), (w[0, i], w[1, i], w[2, i])
        write_approach(
            rows, 0, Meeting((0.0, 0.0, -x[2, i]), velocity, rim, spheres.radius[i]), step
        )
        normal, speed = _normal_and_slip(rows, step)
        apply_law(
            law_on_plane(plane_law, spheres, i, step),
            rows,
            0,
            recall(new, plane_memory, slot[0, i]),
        )
        geometry = (0.0, 0.0, x[2, i]), x[2, i], 0.0
        contact = (spheres.label[0, i], np.int64(-1)), geometry, normal, (speed, plane_friction)
        record_contact(collector, sampling, rows, contact)
