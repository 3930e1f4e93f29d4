"""The contacts of a belt's beads at one moment, with their forces."""

from math import sqrt

from sim.engine.boundary.belt import belt_state
from sim.engine.compile import inlined, kernel
from sim.engine.contact.damping import disk_force
from sim.engine.dynamics.cells import nearest_image

#: Partners that are no beads.
BELT, OBSTACLE = -1, -2


@kernel
def list_bed_contacts(listed, disks, contacts, time, time_step):
    """List the contacts of the present state, see `sim.engine.observe.listed.Listed`.

    A contact of two beads is there twice, from the side of each: as each may feel a force of its
    own, it need not be that of the other. ``contacts`` are those of the loop over steps, and
    ``time`` (s) says where the belt is. Those that the last step has opened are missing where the
    neighbor list no longer holds.
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
            _list(listed, disks.label[0, i], disks.label[0, j], force)
            force = disk_force(law, overlap, (-nx, -nz), (-vx, -vz), disks.mass[j], inverse[0])
            _list(listed, disks.label[0, j], disks.label[0, i], force)
    _list_boundaries(listed, disks, contacts, time, time_step)


@inlined
def _list_boundaries(listed, disks, contacts, time, time_step):
    law, belt, obstacle, x = contacts.law, contacts.belt, contacts.obstacle, disks.taylor
    height, (belt_x, belt_z) = belt_state(belt, time)
    for i in range(disks.mass.size):
        radius, mass = disks.radius[i], disks.mass[i]
        vx, vz = x[1, 0, i] / time_step, x[1, 1, i] / time_step
        overlap = radius + belt.surface + height - x[0, 1, i]
        if overlap > 0.0:
            relative = (vx - belt_x, vz - belt_z)
            force = disk_force(law, overlap, (0.0, -1.0), relative, mass, belt.inverse_mass)
            _list(listed, disks.label[0, i], BELT, force)
        if obstacle.radius > 0.0:
            dx = nearest_image(obstacle.x - x[0, 0, i], contacts.pairs.box, 0)
            dz = obstacle.z - x[0, 1, i]
            distance = sqrt(dx * dx + dz * dz)
            overlap = radius + obstacle.radius - distance
            if overlap > 0.0:
                normal = (dx / distance, dz / distance)
                force = disk_force(law, overlap, normal, (vx, vz), mass, 0.0)
                _list(listed, disks.label[0, i], OBSTACLE, force)


@inlined
def _list(listed, first, second, force):
    row = listed.number[0]
    listed.number[0] += 1
    if row < listed.pair.shape[0]:
        listed.pair[row, 0], listed.pair[row, 1] = first, second
        listed.force[row, 0], listed.force[row, 1] = force
