"""Samples of the belt, taken without leaving compiled code, and the contacts of its beads."""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import types

from sim.engine.boundary.belt import belt_height, belt_state, stored_in_belt, stored_in_obstacle
from sim.engine.compile import address_of, call, exact, inlined, kernel, kind_of
from sim.engine.contact.damping import disk_force
from sim.engine.dynamics.cells import NOT_FINITE, OK, is_finite, nearest_image
from sim.engine.dynamics.disks import stored_in_disks
from sim.engine.observe.profiles import (
    AREA,
    CENTRE,
    LEVELS,
    WAVES,
    Field,
    Profile,
    Squares,
    add_sample,
    bed_energies,
    count_beads,
    empty_profile,
    waves,
)
from sim.engine.observe.samples import append_contact, zero_samples
from sim.engine.systems import shaking


class Calls(NamedTuple):
    """Addresses of the kernels that take a sample."""

    advance: int
    stored_in_disks: int
    stored_in_belt: int
    stored_in_obstacle: int
    belt_height: int
    add_sample: int


class Sampling(NamedTuple):
    """Settings of sampling: ``calls`` of kernels; number of ``samples``, ``steps`` apart, with or
    without ``profiles``; ``amplitude`` of the belt (m), height of a ``slice`` (m), ``squares`` of
    the field."""

    calls: Calls
    samples: int
    steps: int
    profiles: bool
    amplitude: float
    slice: float
    squares: Squares


class BedSamples(NamedTuple):
    """Results of up to K samples of N beads.

    ``number`` (1,) of samples so far; ``clock`` (1,) processor time (µs) in the loop over time
    steps; ``sums`` (K, 12) over the steps, see ``Shaking``; ``stored`` (K, 3) energy (J) in the
    springs between beads, to the belt and to the obstacle; ``state`` (K, 3) see ``bed_energies``;
    ``waves`` (K, 5, 2) see ``waves``; ``mass`` and ``height`` (K, N) of the beads (kg, m); profiles
    by ``centres`` and ``area`` and the ``field``, with one more axis, the first.
    """

    number: np.ndarray
    clock: np.ndarray
    sums: np.ndarray
    stored: np.ndarray
    state: np.ndarray
    waves: np.ndarray
    mass: np.ndarray
    height: np.ndarray
    centres: Profile
    area: Profile
    field: Field


def make_samples(samples: int, beads: int, slices: int, squares: Squares) -> BedSamples:
    """Return arrays for so many samples."""
    return BedSamples(
        number=np.zeros(1, np.int64),
        clock=np.zeros(1, np.int64),
        sums=np.zeros((samples, shaking.SUMS)),
        stored=np.zeros((samples, 3)),
        state=np.zeros((samples, 3)),
        waves=np.zeros((samples, WAVES, 2)),
        mass=np.zeros((samples, beads)),
        height=np.zeros((samples, beads)),
        centres=zero_samples(samples, empty_profile(slices, 2)),
        area=zero_samples(samples, empty_profile(slices, 2)),
        field=zero_samples(samples, squares.empty()),
    )


def make_calls(disks, contacts, loop, motion) -> Calls:
    """Return the addresses of the kernels for these arguments and others of the same law."""
    law, pairs, belt, obstacle, _ = contacts
    kind = kind_of(law, belt, motion.integrator)
    profile, x, z = empty_profile(1, 2), disks.taylor[0], disks.radius
    return Calls(
        address_of(shaking.advance_disks, kind, disks, contacts, loop, motion, 0),
        address_of(stored_in_disks, kind, law, disks, pairs),
        address_of(stored_in_belt, kind, law, disks, belt, 0.0),
        address_of(stored_in_obstacle, kind, law, disks, obstacle, pairs.box),
        address_of(belt_height, kind, belt, 0.0),
        address_of(add_sample, kind, profile, AREA, 0.0, z, z, x),
    )


@exact
def sample_bed(disks, contacts, loop, motion, sampling, samples):
    """Take samples; return a status.

    On LIST_FULL nothing is lost, see ``advance_disks``: give the list more room and call again. Any
    other status but OK ends the sample under way, which does not count.
    """
    law, pairs, belt, obstacle, _ = contacts
    calls, time_step = sampling.calls, motion.integrator.time_step
    for k in range(samples.number[0], sampling.samples):
        done = loop.step[0] % sampling.steps
        if done == 0:
            for column in range(loop.sums.size):
                loop.sums[column] = 0.0
        began = _clock()
        status = call(calls.advance, 0, disks, contacts, loop, motion, sampling.steps - done)
        samples.clock[0] += _clock() - began
        if status != OK:
            return status
        if not is_finite(disks.taylor):
            return NOT_FINITE
        time, box = loop.step[0] * time_step, pairs.box
        stored = samples.stored[k]
        stored[0] = call(calls.stored_in_disks, 0.0, law, disks, pairs)
        stored[1] = call(calls.stored_in_belt, 0.0, law, disks, belt, time)
        stored[2] = call(calls.stored_in_obstacle, 0.0, law, disks, obstacle, box)
        for column in range(loop.sums.size):
            samples.sums[k, column] = loop.sums[column]
        _note_state(samples, k, disks, time_step, sampling.amplitude, box.length[0])
        if sampling.profiles:
            height = call(calls.belt_height, 0.0, belt, time)
            _add_profiles(sampling, samples, k, disks, height, time_step)
        samples.number[0] += 1
    return OK


@exact
def _note_state(samples, k, disks, time_step, amplitude, width):
    """Fill the entries of sample k that depend on the present state alone."""
    for i in range(disks.mass.size):
        samples.mass[k, i], samples.height[k, i] = disks.mass[i], disks.taylor[0, 1, i]
    kinetic, height, near = bed_energies(disks.taylor, disks.mass, time_step, amplitude)
    samples.state[k, 0], samples.state[k, 1], samples.state[k, 2] = kinetic, height, near
    waves(disks.taylor[0, 0], width, samples.waves[k])


@exact
def _add_profiles(sampling, samples, k, disks, belt, time_step):
    """Fill the profiles of sample k, above a ``belt`` at this height (m), and its field."""
    add, beads = sampling.calls.add_sample, disks.radius.size
    height, velocity = np.empty(beads), np.empty((2, beads))
    for i in range(beads):
        height[i] = disks.taylor[0, 1, i] - belt
        velocity[0, i] = disks.taylor[1, 0, i] / time_step
        velocity[1, i] = disks.taylor[1, 1, i] / time_step
    centres, area = _profile(samples.centres, k), _profile(samples.area, k)
    call(add, None, centres, CENTRE, sampling.slice, height, disks.radius, velocity)
    call(add, None, area, AREA, sampling.slice, height, disks.radius, velocity)
    field = Field(samples.field.samples[k], samples.field.count[k], samples.field.moved[k])
    field.samples[0] = 0.0
    for column in range(sampling.squares.columns):
        for level in range(LEVELS):
            field.count[column, level] = field.moved[column, level] = 0.0
    count_beads(field, sampling.squares, disks.taylor, time_step)


@exact
def _profile(profiles, k):
    """Return the cleared profile of sample k."""
    samples, weight, moved, relative, squared = profiles
    samples[k, 0] = 0.0
    for h in range(weight.shape[1]):
        weight[k, h] = moved[k, h] = 0.0
        for d in range(relative.shape[2]):
            relative[k, h, d] = squared[k, h, d] = 0.0
    return Profile(samples[k], weight[k], moved[k], relative[k], squared[k])


#: Processor time of this process in millionths of a second, by the C library.
_clock = types.ExternalFunction("clock", types.int64())

#: Numbers of partners other than beads.
BELT, OBSTACLE = -1, -2


@kernel
def list_bed_contacts(contact_list, disks, contacts, time, time_step):
    """Write the contacts of the present state into a ``ContactList``.

    A contact of two beads is listed twice, once for each bead, because the two may feel different
    forces. ``contacts`` are those of the loop over steps; ``time`` (s) sets the position of the
    belt. Where the neighbor list no longer holds, contacts that began in the last step are missing.
    """
    law, pairs, x = contacts.law, contacts.pairs, disks.taylor
    for p in range(pairs.start[-1]):
        i, j = pairs.first[p], pairs.second[p]
        dx = nearest_image(x[0, 0, j] - x[0, 0, i], pairs.box, 0)
        dz = x[0, 1, j] - x[0, 1, i]
        distance = sqrt(dx * dx + dz * dz)
        overlap, nx, nz = pairs.reach[p] - distance, dx / distance, dz / distance
        if overlap > 0.0:
            vx, vz = (x[1, 0, i] - x[1, 0, j]) / time_step, (x[1, 1, i] - x[1, 1, j]) / time_step
            inverse = 1.0 / disks.mass[i], 1.0 / disks.mass[j]
            force = disk_force(law, overlap, (nx, nz), (vx, vz), disks.mass[i], inverse[1])
            append_contact(contact_list, (disks.label[0, i], disks.label[0, j]), force)
            force = disk_force(law, overlap, (-nx, -nz), (-vx, -vz), disks.mass[j], inverse[0])
            append_contact(contact_list, (disks.label[0, j], disks.label[0, i]), force)
    _list_boundaries(contact_list, disks, contacts, time, time_step)


@inlined
def _list_boundaries(contact_list, disks, contacts, time, time_step):
    law, belt, obstacle, x = contacts.law, contacts.belt, contacts.obstacle, disks.taylor
    height, (belt_x, belt_z) = belt_state(belt, time)
    for i in range(disks.mass.size):
        radius, mass = disks.radius[i], disks.mass[i]
        vx, vz = x[1, 0, i] / time_step, x[1, 1, i] / time_step
        overlap = radius + belt.surface + height - x[0, 1, i]
        if overlap > 0.0:
            relative = (vx - belt_x, vz - belt_z)
            force = disk_force(law, overlap, (0.0, -1.0), relative, mass, belt.inverse_mass)
            append_contact(contact_list, (disks.label[0, i], BELT), force)
        if obstacle.radius > 0.0:
            dx = nearest_image(obstacle.x - x[0, 0, i], contacts.pairs.box, 0)
            dz = obstacle.z - x[0, 1, i]
            distance = sqrt(dx * dx + dz * dz)
            overlap = radius + obstacle.radius - distance
            if overlap > 0.0:
                normal = (dx / distance, dz / distance)
                force = disk_force(law, overlap, normal, (vx, vz), mass, 0.0)
                append_contact(contact_list, (disks.label[0, i], OBSTACLE), force)
