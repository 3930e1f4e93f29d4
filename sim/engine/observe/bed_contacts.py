"""The contacts of a belt's beads at one moment, with their forces."""

from math import sqrt

from sim.engine.boundary.belt import belt_state
from sim.engine.compile import inlined, kernel
from sim.engine.contact.damping import disk_force
from sim.engine.dynamics.cells import nearest_image

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
            _append(contact_list, disks.label[0, i], disks.label[0, j], force)
            force = disk_force(law, overlap, (-nx, -nz), (-vx, -vz), disks.mass[j], inverse[0])
            _append(contact_list, disks.label[0, j], disks.label[0, i], force)
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
            _append(contact_list, disks.label[0, i], BELT, force)
        if obstacle.radius > 0.0:
            dx = nearest_image(obstacle.x - x[0, 0, i], contacts.pairs.box, 0)
            dz = obstacle.z - x[0, 1, i]
            distance = sqrt(dx * dx + dz * dz)
            overlap = radius + obstacle.radius - distance
            if overlap > 0.0:
                normal = (dx / distance, dz / distance)
                force = disk_force(law, overlap, normal, (vx, vz), mass, 0.0)
                _append(contact_list, disks.label[0, i], OBSTACLE, force)


@inlined
def _append(contact_list, first, second, force):
    row = contact_list.number[0]
    contact_list.number[0] += 1
    if row < contact_list.pair.shape[0]:
        contact_list.pair[row, 0], contact_list.pair[row, 1] = first, second
        contact_list.force[row, 0], contact_list.force[row, 1] = force
