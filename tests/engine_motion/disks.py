"""Disks in motion under the engine's kernels alone."""

import numpy as np

from sim.engine.boundary.belt import Belt, Obstacle
from sim.engine.compile import address_of
from sim.engine.contact.damping import SpringDamping
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.disks import Gear, make_disks
from sim.engine.dynamics.neighbors import double_room, empty_pair_list, make_search
from sim.engine.systems import shaking
from tests.engine_motion.helpers import BEAD, BEAD_MASS, bead_law, initial_order, run_on

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
