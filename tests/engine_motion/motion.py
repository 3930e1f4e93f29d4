"""Spheres and disks in motion under the kernels alone, and impacts of two or with the plane."""

import numpy as np

from sim.engine import impact
from sim.engine.boundary.belt import Belt, Obstacle
from sim.engine.compile import address_of
from sim.engine.contact.damping import SpringDamping
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.disks import Gear, make_disks
from sim.engine.dynamics.neighbors import double_room, empty_pair_list, make_search
from sim.engine.systems import shaking
from sim.engine.systems.moving import Motion
from sim.engine.systems.sharing import refresh_together
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


class SphereMotion(Motion):
    """Spheres under the engine's leap-frog, by default the chute's own on an unbounded plane.

    Without a ``box``, positions are those nearest to the origin.
    """

    def __init__(
        self,
        position,
        velocity,
        spin=0.0,
        *,
        law: tuple | None = None,
        plane_law: tuple | None = None,
        laws: tuple | None = None,
        radius=RADIUS,
        mass=MASS,
        box=None,
        steps_per_collision: float = 40,
        time_step: float | None = None,
        skin: float = 0.3 * 2 * RADIUS,
        **options,
    ):
        law = law or sphere_law()
        super().__init__(
            position,
            velocity,
            spin,
            laws=laws or (law, plane_law or law),
            radius=radius,
            mass=mass,
            box=box or UNBOUNDED,
            time_step=time_step or collision_time(law) / steps_per_collision,
            skin=skin,
            **options,
        )
        self.length, self.unbounded = (*(box or UNBOUNDED), 0.0), box is None

    def refresh(self) -> int:
        """Rebuild the list of a single thread; return the status."""
        return refresh_together(*self._moved())

    @property
    def position(self) -> np.ndarray:
        """Positions (N, 3), m."""
        place = super().position
        return wrapped(place, *self.length) if self.unbounded else place

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
    def moment_of_inertia(self) -> np.ndarray:
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
        return 0.5 * float(moving + (self.moment_of_inertia[:, None] * self.spin**2).sum())

    def momentum(self) -> np.ndarray:
        """Total momentum (3,), kg m/s."""
        return self.mass @ self.velocity

    def angular_momentum(self) -> np.ndarray:
        """Orbital angular momentum about the origin and that of the spins (3,), kg m2/s."""
        orbital = self.mass @ np.cross(self.position, self.velocity)
        return orbital + self.moment_of_inertia @ self.spin


class Impacts(impact.Impacts):
    """Impacts of spheres of which the tests know all."""

    motion_type = SphereMotion

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
