"""Spheres in motion under the engine's kernels alone."""

from functools import partial

import numpy as np

from sim.engine.boundary.drive import Gravity
from sim.engine.boundary.plane import make_plane
from sim.engine.contact.friction import enlarge_memory, make_memory
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.neighbors import double_room, empty_pair_list
from sim.engine.dynamics.spheres import SOLID, make_scratch, make_spheres
from sim.engine.dynamics.team import Team
from sim.engine.systems import leap_frog
from sim.engine.systems.sharing import Thread
from tests.engine_motion.helpers import (
    MASS,
    RADIUS,
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
    ):
        law = law or sphere_law()
        self.laws = (law, plane_law or law)
        self.time_step = time_step or collision_time(law) / steps_per_collision
        self.spheres = make_spheres(position, velocity, radius, mass, threads, orientations)
        self.spheres.rim[:] = np.transpose(spin) * self.spheres.radius
        number = len(self.spheres.mass)
        self.length = (*(box or UNBOUNDED), 0.0)
        self.box, self.unbounded = make_box(*self.length[:2]), box is None
        self.pairs = empty_pair_list(self.spheres.radius, self.box, skin, room)
        self.plane = make_plane(self.laws[1], number, threads)
        self.memory = make_memory(self.laws[0], len(self.pairs.touching))
        self.team, self.scratch = Team(threads), [make_scratch() for _ in range(threads)]
        self.flow = leap_frog.make_flow(number, threads)
        self.gravity, self.overlap_limit = gravity, overlap_limit

    def advance(self, steps: int) -> int:
        """Advance by a number of steps, once; return the status."""
        return self.team.run(partial(self._advance, steps))

    def _advance(self, steps: int, rank: int) -> int:
        contacts = leap_frog.FlowContacts(self.laws, self.pairs, self.plane, self.memory)
        drive = Gravity(self.gravity)
        motion = leap_frog.Motion(drive, self.time_step, self.overlap_limit, SOLID)
        thread = Thread(rank, self.team.gate, self.scratch[rank])
        return leap_frog.advance_spheres(self.spheres, contacts, self.flow, motion, thread, steps)

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
