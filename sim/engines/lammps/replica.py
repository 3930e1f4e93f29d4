"""Chute and conveyor computed by LAMMPS: our initial state, samples and profiles, its motion.

Our velocities live half a step before the positions, those of LAMMPS at the same time. Means over
the steps of a sample follow from what it has at the ends: the mean velocity from the way, and the
forces on the plane from the change of momentum that gravity does not make. Both are exact.
"""

from importlib.metadata import version
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from sim.engine.boundary.drive import plane_velocity, tilt_after
from sim.engine.dynamics.cells import OK, OVERLAP, REASONS, BlowUp
from sim.engine.dynamics.spheres import unrotated_orientations
from sim.engine.systems import leap_frog
from sim.engine.systems.chute import Chute, PlaneFlow
from sim.engine.systems.conveyor import Conveyor
from sim.engines.lammps.deck import deck, frame_speed, particle_data
from sim.engines.lammps.process import DATA, RESTART, Process
from sim.parameters import point_id

#: LAMMPS counts the cells that a particle has crossed up to this number, then anew.
IMAGES = 1024


class LammpsFlow(PlaneFlow):
    """A flow on a plane that LAMMPS moves.

    ``spheres`` and ``pairs`` are those after the step ``adopted``, the pairs those that touch;
    ``place`` (2, N) is the place along x in LAMMPS' frame then (m), and the number of its cell.
    """

    state_names: tuple[str, ...] = (
        *("spheres", "flow", "travelled", "lost", "work_done", "adopted", "place", "restart"),
    )

    def __init__(self, *arguments: Any):
        super().__init__(*arguments)
        number = self.spheres.radius.size
        self.spheres = self.spheres._replace(orientation=unrotated_orientations(0))
        self.place = np.zeros((2, number))
        self.place[0] = self.spheres.position[0] % self.box.length[0]
        self._speed = frame_speed(self.parameters)
        self._process: Process | None = None
        self._restart = np.zeros(0, np.uint8)
        self.adopted = 0

    @property
    def provenance(self) -> dict[str, str]:
        """Attributes of the run file: the engine, its version, and the deck to run it by hand."""
        commands = deck(self.parameters, self.time_step, DATA, is_restart=False)
        commands.append(f"run {self.parameters.steps}")
        return {
            "engine": "lammps",
            "engine_version": f"LAMMPS {version('lammps')}",
            "deck": "\n".join([*commands, ""]),
        }

    @property
    def restart(self) -> np.ndarray:
        """The bytes of LAMMPS' restart file for the present step, empty before the first."""
        return self._process.save() if self._process else self._restart

    @restart.setter
    def restart(self, content: np.ndarray) -> None:
        self._restart, self._process = content, None

    @property
    def data(self) -> str:
        """The data file of the particles in the initial state, whose contacts have no forces."""
        velocity = self.spheres.velocity + 0.5 * self._pull(1)[:, None]
        velocity[:, self.spheres.mass == 0.0] = 0.0
        velocity[0] -= self._speed
        return particle_data(self.parameters, self.spheres, velocity)

    def _first_changes(self) -> tuple[np.ndarray, np.ndarray]:
        # LAMMPS takes the velocities at t = 0, and its own first half step.
        change = np.zeros_like(self.spheres.velocity)
        return change + self._pull(1)[:, None] + self._frame_change(), np.zeros_like(change)

    def _start(self) -> Process:
        process = Process(point_id(self.parameters), self.parameters.ranks)
        if is_restart := bool(self._restart.size):
            self._restart.tofile(process.folder / RESTART)
        else:
            (process.folder / DATA).write_text(self.data)
        start = RESTART if is_restart else DATA
        process.set_up(deck(self.parameters, self.time_step, start, is_restart))
        return process

    def _advance(self, steps: int) -> int:
        if self._process is None:
            self._process = self._start()
        before = self._process.working_time()
        self._process.advance(steps)
        self.loop_time += self._process.working_time() - before
        self.flow.step[0] += steps
        self.flow.sums[leap_frog.STEPS] += steps
        return OK

    def _continue(self, steps: int) -> None:
        super()._continue(steps)
        if self._process and self.flow.step[0] > self.adopted:
            self._adopt(self._process.snapshot())

    def _pull(self, steps: int) -> np.ndarray:
        """Return the change of velocity (3,) by the drive in the last steps, m/s.

        They end half a step after the present positions where that many are still to come: before
        the first step it is what the first one will make.
        """
        if not self.tilt:
            return np.array(self.gravity) * (steps * self.time_step)
        last = max(int(self.flow.step[0]), 1)
        every = [tilt_after(self.tilt, step)[1:] for step in range(last - steps, last)]
        along, upward = self.time_step * np.sum(every, axis=0)
        return np.array([along, 0.0, upward])

    def _adopt(self, state: dict[str, np.ndarray]) -> None:
        """Take the state over, and add what happened since the last one to the sums."""
        spheres, sums, box = self.spheres, self.flow.sums, self.box.length
        steps, mobile = int(self.flow.step[0]) - self.adopted, spheres.mass > 0.0
        self.adopted += steps
        if not np.isfinite(state["position"]).all():
            raise BlowUp(f"a position is not finite at step {self.flow.step[0]} {self._moment()}")
        place = np.stack([state["position"][0], state["image"][0]])
        cells = (place[1] - self.place[1] + IMAGES // 2) % IMAGES - IMAGES // 2
        way = place[0] - self.place[0] + cells * box[0] + self._speed * steps * self.time_step
        self.place = place
        sums[leap_frog.MOMENTUM] += (spheres.mass * way).sum() / self.time_step
        momentum = (spheres.mass * spheres.velocity).sum(axis=1)
        rate, radius = 0.5 * self.time_step * spheres.inverse_mass, spheres.radius
        shift = self._speed * self.flow.step[0] * self.time_step
        spheres.position[:] = state["position"]
        spheres.position[0] += shift
        for axis, length in enumerate(box[:2]):
            # The rest of a tiny negative number is the length itself.
            spheres.position[axis] %= length
            spheres.position[axis, spheres.position[axis] >= length] = 0.0
        spheres.velocity[:] = np.where(mobile, state["velocity"] - rate * state["force"], 0.0)
        spheres.velocity[0, mobile] += self._speed
        spin_rate = rate / (self.inertia * radius**2)
        spheres.rim[:] = radius * (state["spin"] - spin_rate * state["torque"])
        momentum = (spheres.mass * spheres.velocity).sum(axis=1) - momentum
        push = (momentum - self.mass * self._pull(steps)) / self.time_step
        sums[leap_frog.PLANE_X] += push[0]
        sums[leap_frog.PLANE_Z] += push[2]
        self._find_contacts(mobile)
        touching = 2 * int(self.pairs.start[-1]) + int((spheres.position[2] < radius)[mobile].sum())
        sums[leap_frog.CONTACTS] += steps * touching

    def _find_contacts(self, mobile: np.ndarray) -> None:
        """Make ``pairs`` those that touch; raise ``BlowUp`` for overlaps beyond the limit."""
        spheres, box = self.spheres, np.array([*self.box.length[:2], 0.0])
        tree = cKDTree(spheres.position.T, boxsize=box)
        near = tree.query_pairs(2.0 * spheres.radius.max(), output_type="ndarray")
        near = near[mobile[near].any(axis=1)]
        first, second = near.T
        gap = spheres.position[:, first] - spheres.position[:, second]
        gap[:2] -= box[:2, None] * np.round(gap[:2] / box[:2, None])
        reach = spheres.radius[first] + spheres.radius[second]
        distance = np.sqrt((gap**2).sum(axis=0))
        overlap = np.concatenate(
            [1.0 - distance / reach, 0.5 - 0.5 * (spheres.position[2] / spheres.radius)[mobile]]
        )
        if overlap.size and overlap.max() >= self.parameters.overlap_limit:
            step = self.flow.step[0]
            raise BlowUp(f"{REASONS[OVERLAP]} at step {step} {self._moment()}")
        touches = distance < reach
        self.pairs = self.pairs._replace(
            first=first[touches].astype(np.uint32),
            second=second[touches].astype(np.uint32),
            reach=reach[touches],
            start=np.full_like(self.pairs.start, touches.sum()),
        )

    def _values(self, state: Any) -> dict[str, np.ndarray]:
        values = super()._values(state)
        return {name: values[name] for name in self.series}


class LammpsChute(LammpsFlow, Chute):
    """A chute flow that LAMMPS moves."""


class LammpsConveyor(LammpsFlow, Conveyor):
    """A flow on a vibrating plane that LAMMPS moves, in the frame of the plane."""

    def _pull(self, steps: int) -> np.ndarray:
        end = max(self.flow.step[0], 1) - 0.5
        times = (end - steps) * self.time_step, end * self.time_step
        pull = super()._pull(steps)
        for axis, row in enumerate((0, 2)):
            before, after = (plane_velocity(self.drive, axis, time) for time in times)
            pull[row] -= after - before
        return pull


#: Replicates by system.
REPLICAS: dict[str, Any] = {"chute": LammpsChute, "conveyor": LammpsConveyor}
