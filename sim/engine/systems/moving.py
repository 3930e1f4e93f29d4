"""Spheres above the plane, their contacts and their threads, within a system or without one."""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from sim.engine.boundary.drive import Gravity
from sim.engine.boundary.plane import make_plane
from sim.engine.compile import address_of, call_directly, kind_of
from sim.engine.contact.friction import enlarge_memory, make_memory, turning_numbers
from sim.engine.dynamics.cells import LIST_FULL, BlowUp, Box, failure_reason, make_box
from sim.engine.dynamics.neighbors import Bond, double_room, empty_pair_list
from sim.engine.dynamics.spheres import SOLID, Spheres, make_scratch, make_spheres
from sim.engine.dynamics.team import Team
from sim.engine.systems import leap_frog
from sim.engine.systems.sharing import Thread, refresh_together


class MovingSpheres:
    """Spheres above the plane, their contacts, and the threads that advance them together.

    ``drive`` and ``inertia`` are those of `leap_frog.Motion`.
    """

    drive: Any
    time_step: float
    overlap_limit: float
    inertia: float

    def set_up(
        self,
        spheres: Spheres,
        laws: tuple[NamedTuple, NamedTuple],
        drive: NamedTuple,
        box: Box,
        skin: float,
        reach: float = 0.0,
        room: int = 8,
    ) -> None:
        """Take spheres in their initial state, which touch nothing yet.

        Laws are those of `leap_frog.FlowContacts`; in m the ``skin`` of the neighbor list, which
        has ``room`` for so many pairs per sphere, and the ``reach`` of the laws beyond contact.
        """
        number, threads = spheres.radius.size, len(spheres.force)
        self.spheres, self.laws, self.drive, self.box = spheres, laws, drive, box
        self.kind = kind_of(laws, drive)
        self.pairs = empty_pair_list(spheres.radius, box, skin, room, reach)
        self.plane = make_plane(laws[1], number, threads)
        self.memory = make_memory(laws[0], len(self.pairs.touching))
        self.bond = Bond(turning_numbers(laws[0]), reach)
        self.team, self.scratch = Team(threads), [make_scratch() for _ in range(threads)]
        self.flow = leap_frog.make_flow(number, threads, fixed=bool((spheres.mass == 0.0).any()))

    def make_room(self) -> None:
        """Double the room of the list."""
        self.pairs = double_room(self.pairs)
        self.memory = enlarge_memory(self.memory, len(self.pairs.touching))

    def _contacts(self) -> leap_frog.FlowContacts:
        return leap_frog.FlowContacts(self.laws, self.pairs, self.plane, self.memory, self.bond)

    def _moved(self, rank: int = 0) -> tuple[Any, ...]:
        """Return the arguments of the kernel that rebuilds the list."""
        thread = Thread(rank, self.team.gate, self.scratch[rank])
        memory, sharing = self.memory[0], self.flow.sharing
        return self.spheres, self.pairs, self.plane, sharing, thread, memory, self.bond

    def _advance(self, steps: int) -> int:
        return self.team.run(partial(self._advance_thread, steps))

    def _advance_thread(self, steps: int, rank: int) -> int:
        spheres, *_, thread, _, _ = moved = self._moved(rank)
        refresh = address_of(refresh_together, self.kind, *moved)
        limit, inertia = self.overlap_limit, self.inertia
        motion = leap_frog.Motion(self.drive, self.time_step, limit, inertia, refresh)
        arguments = spheres, self._contacts(), self.flow, motion, thread, steps
        return call_directly(leap_frog.advance_spheres, self.kind, *arguments)


class Motion(MovingSpheres):
    """Spheres above the plane under the engine's leap-frog, without a system around them.

    The engine sorts its ``spheres``; the properties are in the order of the initial state.
    ``box`` (m) has the periods along x and y.
    """

    def __init__(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        spin: Any = 0.0,
        *,
        laws: tuple[NamedTuple, NamedTuple],
        radius: Any,
        mass: Any,
        time_step: float,
        box: tuple[float, float],
        skin: float,
        gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
        room: int = 12,
        orientations: bool = False,
        overlap_limit: float = 0.5,
        threads: int = 1,
        inertia: float = SOLID,
        reach: float = 0.0,
    ):
        self.time_step, self.overlap_limit, self.inertia = time_step, overlap_limit, inertia
        spheres = make_spheres(position, velocity, radius, mass, threads, orientations)
        spheres.rim[:] = np.transpose(spin) * spheres.radius
        self.set_up(spheres, laws, Gravity(gravity), make_box(*box), skin, reach, room)

    def advance(self, steps: int) -> int:
        """Advance by a number of steps, once; return the status."""
        return self._advance(steps)

    def run(self, steps: int) -> Any:
        """Run for a number of steps, giving the list more room as needed; return the motion.

        Raises ``BlowUp`` where an overlap exceeds its limit.
        """
        target = self.flow.step[0] + steps
        while (status := self.advance(target - self.flow.step[0])) == LIST_FULL:
            self.make_room()
        if reason := failure_reason(status, self.spheres.position):
            raise BlowUp(f"{reason} at step {self.flow.step[0]}")
        return self

    def _ordered(self, columns: np.ndarray) -> np.ndarray:
        """Return columns (..., N) as rows in the initial order, which cannot be written to."""
        rows = columns.T[np.argsort(self.spheres.label[0])]
        rows.flags.writeable = False
        return rows

    @property
    def position(self) -> np.ndarray:
        """Positions (N, 3), m."""
        return self._ordered(self.spheres.position)

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
