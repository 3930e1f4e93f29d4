"""Spheres in motion without a system around them, and impacts of two or with the plane."""

from collections.abc import Sequence
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sim.engine.boundary.drive import Gravity
from sim.engine.boundary.plane import make_plane
from sim.engine.compile import address_of, kind_of
from sim.engine.contact.friction import enlarge_memory, make_memory, turning_numbers
from sim.engine.dynamics.cells import LIST_FULL, BlowUp, failure_reason, make_box
from sim.engine.dynamics.neighbors import Bond, double_room, empty_pair_list
from sim.engine.dynamics.spheres import SOLID, make_scratch, make_spheres
from sim.engine.dynamics.team import Team
from sim.engine.systems import leap_frog
from sim.engine.systems.sharing import Thread, refresh_together

#: Distance of impacts from each other, in largest radii, besides what they move meanwhile.
APART = 12

#: From the first sphere of a pair to the second one, and the way along which that slides.
NORMAL, TANGENT = np.array([0.6, 0.0, 0.8]), np.array([-0.64, 0.6, 0.48])


class Motion:
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
        self.laws, self.time_step = laws, time_step
        self.spheres = make_spheres(position, velocity, radius, mass, threads, orientations)
        self.spheres.rim[:] = np.transpose(spin) * self.spheres.radius
        number = len(self.spheres.mass)
        self.box = make_box(*box)
        self.pairs = empty_pair_list(self.spheres.radius, self.box, skin, room, reach)
        self.plane = make_plane(self.laws[1], number, threads)
        self.memory = make_memory(self.laws[0], len(self.pairs.touching))
        self.bond = Bond(turning_numbers(laws[0]), reach)
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

    def _moved(self, rank: int = 0) -> tuple[Any, ...]:
        """Return the arguments of the kernel that rebuilds the list."""
        thread = Thread(rank, self.team.gate, self.scratch[rank])
        memory, sharing = self.memory[0], self.flow.sharing
        return self.spheres, self.pairs, self.plane, sharing, thread, memory, self.bond

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

    def make_room(self) -> None:
        """Double the room of the list."""
        self.pairs = double_room(self.pairs)
        self.memory = enlarge_memory(self.memory, len(self.pairs.touching))

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


class Impacts:
    """Impacts side by side, each of a sphere with the plane or with another sphere.

    ``radii`` (m) and ``mass`` (kg) are those of both spheres, or of the one that meets the plane.
    ``speeds`` (n,) are those along the normal (m/s) of n impacts, ``slides`` those along which the
    second surface slides, ``spins`` (n, p, 3) those of all spheres (1/s) along normal, tangent and
    the direction across both. The momenta of a pair cancel. Impacts begin after ``phases`` of a
    time step (s); without them they differ. Laws act up to ``reach`` (m) beyond contact.
    """

    motion_type: ClassVar[type[Motion]] = Motion

    def __init__(
        self,
        law: Any,
        radii: Sequence[float],
        mass: Any,
        time_step: float,
        speeds: Any,
        slides: Any = 0.0,
        spins: Any = 0.0,
        phases: Any = None,
        longest: int = 2000,
        reach: float = 0.0,
    ):
        self.radii, self.mass = np.array(radii, float), np.array(mass, float)
        self.is_pair = len(radii) == 2
        self.frame = np.array([NORMAL, TANGENT] if self.is_pair else [[0, 0, -1.0], [0, 1.0, 0]])
        self.axes = np.vstack([self.frame, np.cross(*self.frame)])
        normal, tangent = self.frame
        speeds = np.atleast_1d(np.array(speeds, float))
        slides = np.broadcast_to(slides, speeds.shape)
        self.start = slides[:, None] * tangent - speeds[:, None] * normal
        self.number = len(speeds)
        phases = np.linspace(0.1, 0.9, self.number) if phases is None else phases
        self.delays = np.broadcast_to(time_step * np.array(phases), speeds.shape) + reach / speeds
        way = longest * time_step * np.linalg.norm(self.start, axis=1).max()
        size, place = self.radii.max(), np.arange(self.number)
        spacing, columns = APART * size + 2 * way, int(np.ceil(self.number**0.5))
        height = 5 * APART * size + way if self.is_pair else size
        corner = spacing * (np.stack([place % columns, place // columns, place], axis=1) + 0.5)
        corner[:, 2] = height
        delays = self.delays[:, None]
        if self.is_pair:
            shares = self.mass[::-1] / sum(self.mass)
            second = corner + sum(self.radii) * normal - delays * self.start
            position = np.stack([corner, second], axis=1).reshape(-1, 3)
            velocity = np.stack([-shares[0] * self.start, shares[1] * self.start], axis=1)
        else:
            position, velocity = corner + delays * self.start, -self.start
        spins = np.broadcast_to(spins, (self.number, len(radii), 3)) @ self.axes
        self.motion = self.motion_type(
            position,
            velocity.reshape(-1, 3),
            spins.reshape(-1, 3),
            laws=(law, law),
            time_step=time_step,
            radius=np.tile(self.radii, self.number),
            mass=np.tile(self.mass, self.number),
            box=(spacing * columns,) * 2,
            skin=0.6 * size,
            reach=reach,
        )

    def velocities(self) -> np.ndarray:
        """Return velocities of the second along normal and tangent, and all rims', m/s (n, 2 + p).

        Rims move along the tangent where they touch.
        """
        velocity = self.motion.velocity.reshape(self.number, -1, 3)
        relative = velocity[:, 1] - velocity[:, 0] if self.is_pair else -velocity[:, 0]
        rims = self.radii * (self.motion.spin.reshape(velocity.shape) @ self.axes[2])
        return np.hstack([relative @ self.frame.T, rims])

    def contacts(self) -> tuple[np.ndarray, np.ndarray]:
        """Return overlaps (n,) in m and normals (n, 3), from the first partner to the second."""
        place = self.motion.position.reshape(self.number, -1, 3)
        if not self.is_pair:
            return self.radii[0] - place[:, 0, 2], np.tile(self.frame[0], (self.number, 1))
        apart = place[:, 1] - place[:, 0]
        distance = np.linalg.norm(apart, axis=1)
        return self.radii.sum() - distance, apart / distance[:, None]

    def record(self, longest: int) -> dict[str, np.ndarray]:
        """Follow the impacts until all have parted, for so many steps at most.

        Returns overlap (m), normal and tangential force on the first partner (N), and the time
        since it touched (s), each (n, S) over its time steps, not-a-number after its last force;
        the ``duration`` (n,) in s, not-a-number where partners still touch.
        """
        overlaps, forces, met = [], [], np.zeros(self.number, bool)
        for _ in range(longest):
            overlap, normal = self.contacts()
            force = self.motion.run(1).force.reshape(self.number, -1, 3)[:, 0]
            across = self.frame[1] - (normal @ self.frame[1])[:, None] * normal
            overlaps.append(overlap)
            forces.append([-(force * normal).sum(1), -(force * across).sum(1)])
            acts = force.any(axis=1)
            met |= acts
            if met.all() and not acts.any() and (self._parting() > 0).all():
                break
        overlap, (pressed, rubbed) = np.array(overlaps).T, np.array(forces).transpose(1, 2, 0)
        return self._aligned(overlap, pressed, rubbed)

    def _parting(self) -> np.ndarray:
        """Return the velocities along the normals at which partners part, m/s."""
        _, normal = self.contacts()
        velocity = self.motion.velocity.reshape(self.number, -1, 3)
        relative = velocity[:, 1] - velocity[:, 0] if self.is_pair else -velocity[:, 0]
        return (relative * normal).sum(1)

    def _aligned(
        self, overlap: np.ndarray, pressed: np.ndarray, rubbed: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the records of all impacts from the first step of each with a force."""
        acts, steps, step = (pressed != 0) | (rubbed != 0), pressed.shape[1], self.motion.time_step
        first, last = acts.argmax(axis=1), steps - 1 - acts[:, ::-1].argmax(axis=1)
        column = first[:, None] + np.arange((last - first).max() + 1)
        past, column = column > last[:, None], np.minimum(column, steps - 1)
        time = column * step - self.delays[:, None]
        found = {"overlap": overlap, "normal_force": pressed, "tangential_force": rubbed}
        found = {name: np.take_along_axis(rows, column, 1) for name, rows in found.items()}
        found = {
            name: np.where(past, np.nan, rows) for name, rows in (*found.items(), ("time", time))
        }
        # In the step after the last force they move freely: back to where they have parted.
        after = np.minimum(last + 1, steps - 1)
        gap = np.maximum(0.0, -overlap[np.arange(self.number), after])
        parting = self._parting()
        end = after * step - self.delays - gap / np.where(parting > 0, parting, np.inf)
        return found | {"duration": np.where(last < steps - 1, end, np.nan)}
