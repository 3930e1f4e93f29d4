"""Spheres and disks in motion under the kernels alone, and impacts of two or with the plane."""

from functools import partial

import numpy as np

from sim.engine.boundary.belt import Belt, Obstacle
from sim.engine.boundary.drive import Gravity
from sim.engine.boundary.plane import make_plane
from sim.engine.compile import address_of, kind_of
from sim.engine.contact.damping import SpringDamping
from sim.engine.contact.friction import enlarge_memory, make_memory, turning_numbers
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.disks import Gear, make_disks
from sim.engine.dynamics.neighbors import Bond, double_room, empty_pair_list, make_search
from sim.engine.dynamics.spheres import SOLID, make_scratch, make_spheres
from sim.engine.dynamics.team import Team
from sim.engine.systems import leap_frog, shaking
from sim.engine.systems.sharing import Thread, refresh_together
from tests.engine_motion.helpers import (
    BEAD,
    BEAD_MASS,
    MASS,
    RADIUS,
    bead_law,
    collision_time,
    initial_order,
    run_on,
    sphere_law,
    wrapped,
)

#: Periods (m) of what stands for an unbounded plane.
UNBOUNDED = (128 * RADIUS, 128 * RADIUS)


class SphereMotion:
    """Spheres above the plane under the engine's leap-frog, without a system around them.

    The engine sorts its ``spheres``; the properties are in the order of the initial state. Without
    a ``box``, positions are those nearest to the origin.
    """

    def __init__(
        self,
        position,
        velocity,
        spin=0.0,
        *,
        law: tuple | None = None,
        plane_law: tuple | None = None,
        radius=RADIUS,
        mass=MASS,
        box=None,
        gravity=(0.0, 0.0, 0.0),
        steps_per_collision: float = 40,
        time_step: float | None = None,
        skin: float = 0.3 * 2 * RADIUS,
        room: int = 12,
        orientations: bool = False,
        overlap_limit: float = 0.5,
        threads: int = 1,
        inertia: float = SOLID,
        reach: float = 0.0,
    ):
        law = law or sphere_law()
        self.laws = (law, plane_law or law)
        self.time_step = time_step or collision_time(law) / steps_per_collision
        self.spheres = make_spheres(position, velocity, radius, mass, threads, orientations)
        self.spheres.rim[:] = np.transpose(spin) * self.spheres.radius
        number = len(self.spheres.mass)
        self.length = (*(box or UNBOUNDED), 0.0)
        self.box, self.unbounded = make_box(*self.length[:2]), box is None
        self.pairs = empty_pair_list(self.spheres.radius, self.box, skin, room, reach)
        self.plane = make_plane(self.laws[1], number, threads)
        self.memory = make_memory(self.laws[0], len(self.pairs.touching))
        self.bond = Bond(turning_numbers(self.laws[0]), reach)
        self.team, self.scratch = Team(threads), [make_scratch() for _ in range(threads)]
        self.flow = leap_frog.make_flow(number, threads)
        self.gravity, self.overlap_limit, self._inertia = gravity, overlap_limit, inertia

    def advance(self, steps: int) -> int:
        """Advance by a number of steps, once; return the status."""
        return self.team.run(partial(self._advance, steps))

    def _advance(self, steps: int, rank: int) -> int:
        contacts = leap_frog.FlowContacts(self.laws, self.pairs, self.plane, self.memory, self.bond)
        drive, (*_, thread, _, _) = Gravity(self.gravity), (moved := self._moved(rank))
        refresh = address_of(refresh_together, kind_of(*moved), *moved)
        motion = leap_frog.Motion(drive, self.time_step, self.overlap_limit, self._inertia, refresh)
        return leap_frog.advance_spheres(self.spheres, contacts, self.flow, motion, thread, steps)

    def _moved(self, rank: int = 0) -> tuple:
        """Arguments of the kernel that rebuilds the list."""
        thread = Thread(rank, self.team.gate, self.scratch[rank])
        memory, sharing = self.memory[0], self.flow.sharing
        return self.spheres, self.pairs, self.plane, sharing, thread, memory, self.bond

    def refresh(self) -> int:
        """Rebuild the list of a single thread; return the status."""
        return refresh_together(*self._moved())

    def run(self, steps: int) -> "SphereMotion":
        """Advance by a number of steps, giving the list more room as needed."""
        return run_on(self, self.flow, steps)

    def make_room(self) -> None:
        """Double the room of the list."""
        self.pairs = double_room(self.pairs)
        self.memory = enlarge_memory(self.memory, len(self.pairs.touching))

    def _ordered(self, columns) -> np.ndarray:
        return initial_order(columns, self.spheres.label)

    @property
    def position(self) -> np.ndarray:
        """Positions (N, 3), m."""
        place = self._ordered(self.spheres.position)
        return wrapped(place, *self.length) if self.unbounded else place

    @property
    def velocity(self) -> np.ndarray:
        """Velocities (N, 3), m/s."""
        return self._ordered(self.spheres.velocity)

    @property
    def spin(self) -> np.ndarray:
        """Angular velocities (N, 3), 1/s."""
        return self._ordered(self.spheres.rim / self.spheres.radius)

    @property
    def force(self) -> np.ndarray:
        """Contact forces of the last step (N, 3), N."""
        return self._ordered(self.spheres.force[0])

    @property
    def torque(self) -> np.ndarray:
        """Torques of the last step (N, 3), N m."""
        return self._ordered(self.spheres.moment[0] * self.spheres.radius)

    @property
    def orientation(self) -> np.ndarray:
        """Orientations (N, 4) as unit quaternions, or none."""
        quaternions = self.spheres.orientation
        return self._ordered(quaternions) if quaternions.size else quaternions.T

    @property
    def mass(self) -> np.ndarray:
        """Masses (N,), kg."""
        return self._ordered(self.spheres.mass)

    @property
    def inertia(self) -> np.ndarray:
        """Moments of inertia (N,), kg m2."""
        return 0.4 * self.mass * self._ordered(self.spheres.radius) ** 2

    def contacts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """First and second partner, sum of radii and memory (M, C) of the last step's contacts."""
        slot, label = self.pairs.slot[: self.pairs.start[-1]], self.spheres.label[0]
        touched = np.flatnonzero(slot >= 0)
        pairs = label[self.pairs.first[touched]], label[self.pairs.second[touched]]
        memory = self.memory[self.flow.step[0] % 2]
        return *pairs, self.pairs.reach[touched], memory[:, slot[touched]]

    def plane_contacts(self) -> tuple[np.ndarray, np.ndarray]:
        """Spheres that touched the plane in the last step, and the memory (M, C) of it."""
        slot = self.plane.slot[0]
        touched = np.flatnonzero(slot >= 0)
        memory = self.plane.memory[self.flow.step[0] % 2]
        return self.spheres.label[0, touched], memory[:, slot[touched]]

    def energy(self) -> float:
        """Kinetic energy of translation and rotation, J."""
        moving = (self.mass[:, None] * self.velocity**2).sum()
        return 0.5 * float(moving + (self.inertia[:, None] * self.spin**2).sum())

    def momentum(self) -> np.ndarray:
        """Total momentum (3,), kg m/s."""
        return self.mass @ self.velocity

    def angular_momentum(self) -> np.ndarray:
        """Orbital angular momentum about the origin and that of the spins (3,), kg m2/s."""
        orbital = self.mass @ np.cross(self.position, self.velocity)
        return orbital + self.inertia @ self.spin


#: From the first sphere of a pair to the second one, and the way along which that slides.
NORMAL, TANGENT = np.array([0.6, 0.0, 0.8]), np.array([-0.64, 0.6, 0.48])


class Impacts:
    """Impacts that begin at different parts of a time step.

    ``radii`` (m) and ``mass`` (kg) are those of both spheres, or of the one that meets the plane.
    ``speeds`` (n,) are those along the normal (m/s) of n impacts, ``slides`` those along which the
    second surface slides, ``spins`` (n, p, 3) those of all spheres (1/s) along normal, tangent and
    the direction across both. The momenta of a pair cancel.
    """

    def __init__(self, law, radii, mass, time_step, speeds, slides=0.0, spins=0.0):
        self.radii, self.mass = np.array(radii, float), np.array(mass, float)
        self.step, self.is_pair = time_step, len(radii) == 2
        self.frame = np.array([NORMAL, TANGENT] if self.is_pair else [[0, 0, -1.0], [0, 1.0, 0]])
        self.axes = np.vstack([self.frame, np.cross(*self.frame)])
        normal, tangent = self.frame
        speeds = np.atleast_1d(np.array(speeds, float))
        slides = np.broadcast_to(slides, speeds.shape)
        self.start = slides[:, None] * tangent - speeds[:, None] * normal
        self.number = len(speeds)
        delays = self.step * np.linspace(0.1, 0.9, self.number)[:, None]
        place = np.arange(self.number)
        height = 30e-3 if self.is_pair else self.radii[0]
        corner = np.stack([6e-3 * (place % 9), 9e-3 * (place // 9), 0.0 * place + height], axis=1)
        if self.is_pair:
            shares = self.mass[::-1] / sum(self.mass)
            second = corner + sum(self.radii) * normal - delays * self.start
            position = np.stack([corner, second], axis=1).reshape(-1, 3)
            velocity = np.stack([-shares[0] * self.start, shares[1] * self.start], axis=1)
        else:
            position, velocity = corner + delays * self.start, -self.start
        spins = np.broadcast_to(spins, (self.number, len(self.radii), 3)) @ self.axes
        size, mass = (np.tile(values, self.number) for values in (self.radii, self.mass))
        self.motion = SphereMotion(
            position,
            velocity.reshape(-1, 3),
            spins.reshape(-1, 3),
            law=law,
            time_step=self.step,
            radius=size,
            mass=mass,
        )

    @property
    def touching(self) -> int:
        """Number of contacts in the last step."""
        return self.motion.contacts()[0].size + self.motion.plane_contacts()[0].size

    def run(self, steps: int) -> "Impacts":
        """Run for some steps, after which all must have parted."""
        self.motion.run(steps)
        assert not self.touching
        return self

    def run_until_parted(self, most: int = 20_000) -> "Impacts":
        """Run until all have met and parted, for so many steps at most."""
        met = 0
        for _ in range(most // 20):
            self.motion.run(20)
            touching = self.touching
            met = max(met, touching)
            if met == self.number and not touching:
                return self
        raise AssertionError("still in contact")

    def velocities(self) -> np.ndarray:
        """Return velocities of the second along normal and tangent, and all rims', m/s (n, 2 + p).

        Rims move along the tangent where they touch.
        """
        velocity = self.motion.velocity.reshape(self.number, -1, 3)
        relative = velocity[:, 1] - velocity[:, 0] if self.is_pair else -velocity[:, 0]
        rims = self.radii * (self.motion.spin.reshape(velocity.shape) @ self.axes[2])
        return np.hstack([relative @ self.frame.T, rims])

    def slips(self) -> np.ndarray:
        """Return the velocities of the surfaces along each other, m/s (n,)."""
        return self.velocities()[:, 1] - self.velocities()[:, 2:].sum(axis=1)


AT_REST = Belt(0.0, 0.0, 0.0, 0.0, 0.0)
NO_OBSTACLE = Obstacle(0.0, 0.0, 0.0)


class DiskMotion:
    """Disks above the belt under the engine's integrators, without a system around them.

    ``acceleration`` (m/s2) is what the integrator is told of the past; without it the first step is
    a little off, as with every predictor that starts from position and velocity alone. The engine
    sorts its ``disks``; the properties are in the order of the initial state.
    """

    def __init__(
        self,
        position,
        velocity,
        *,
        acceleration=0.0,
        law: SpringDamping | None = None,
        integrator=Gear,
        time_step: float = 2.5e-5,
        radius=0.5 * BEAD,
        mass=BEAD_MASS,
        width: float = 20 * BEAD,
        gravity: float = 0.0,
        belt: Belt = AT_REST,
        obstacle: Obstacle = NO_OBSTACLE,
        skin: float = 0.3 * BEAD,
        room: int = 12,
        overlap_limit: float = 0.95,
        corrections: int = 1,
    ):
        self.law, self.integrator = law or bead_law(), integrator(time_step)
        self.disks = make_disks(position, velocity, radius, mass, time_step)
        self.disks.taylor[2] = 0.5 * np.transpose(acceleration) * time_step**2
        self.loop, self.length, self.box = shaking.make_shaking(), (width, 0.0), make_box(width)
        self.pairs = empty_pair_list(self.disks.radius, self.box, skin, room)
        self.search = make_search(len(self.disks.mass))
        self.belt, self.obstacle = belt, obstacle
        refresh = address_of(shaking.refresh_beads, "", self.disks, self.pairs)
        self.motion = shaking.BedMotion(
            self.integrator, gravity, overlap_limit, corrections, refresh
        )

    def _ordered(self, columns) -> np.ndarray:
        return initial_order(columns, self.disks.label)

    @property
    def taylor(self) -> np.ndarray:
        """Taylor terms (6, N, 2), m."""
        return np.array([self._ordered(term) for term in self.disks.taylor])

    @property
    def position(self) -> np.ndarray:
        """Positions (N, 2), m."""
        return self._ordered(self.disks.taylor[0])

    @property
    def velocity(self) -> np.ndarray:
        """Velocities (N, 2), m/s."""
        return self._ordered(self.disks.taylor[1]) / self.integrator.time_step

    @property
    def force(self) -> np.ndarray:
        """Forces of the last step (N, 2), N."""
        return self._ordered(self.disks.force)

    @property
    def mass(self) -> np.ndarray:
        """Masses (N,), kg."""
        return self._ordered(self.disks.mass)

    @property
    def radius(self) -> np.ndarray:
        """Radii (N,), m."""
        return self._ordered(self.disks.radius)

    def advance(self, steps: int) -> int:
        """Advance by a number of steps, once; return the status."""
        contacts = shaking.BedContacts(self.law, self.pairs, self.belt, self.obstacle, self.search)
        return shaking.advance_disks(self.disks, contacts, self.loop, self.motion, steps)

    def refresh(self) -> int:
        """Rebuild the list; return the status."""
        return shaking.refresh_beads(self.disks, self.pairs)

    def run(self, steps: int) -> "DiskMotion":
        """Advance by a number of steps, giving the list more room as needed."""
        return run_on(self, self.loop, steps)

    def make_room(self) -> None:
        """Double the room of the list."""
        self.pairs = double_room(self.pairs)
