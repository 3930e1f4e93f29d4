"""Walton's inclined chute: spheres, Walton-Braun contacts, a frictional plane, leap-frog."""

from functools import partial
from math import ceil, cos, isfinite, pi, radians, sin
from typing import Any, NamedTuple

import numpy as np

from sim.engine.boundary.drive import Gravity
from sim.engine.boundary.plane import make_plane, stored_in_plane
from sim.engine.calls import DirectCall, kind_of
from sim.engine.compile import working_time
from sim.engine.contact import Partners, law_of
from sim.engine.dynamics.cells import Box, make_box
from sim.engine.dynamics.neighbors import double_room, empty_pair_list
from sim.engine.dynamics.spheres import (
    SOLID,
    enlarge_memory,
    make_memory,
    make_scratch,
    make_spheres,
    stored_in_spheres,
)
from sim.engine.dynamics.status import LIST_FULL, BlowUp, failure_reason
from sim.engine.dynamics.team import Team
from sim.engine.observe.contacts import (
    ContactSums,
    Sampling,
    add_contacts,
    list_contacts,
)
from sim.engine.observe.energies import flow_energies
from sim.engine.observe.overlaps import EDGES, count_overlaps
from sim.engine.observe.profiles import VOLUME, add_sample
from sim.engine.observe.regime import Scales
from sim.engine.observe.sums import Sums, first_samples, zero_samples
from sim.engine.observe.system import ContactList, Samples, no_contacts, no_pause
from sim.engine.systems import leap_frog
from sim.engine.systems.chute_start import Layer, initial_layer
from sim.engine.systems.flow_profiles import FlowProfiles
from sim.engine.systems.series import CHUTE_LEDGER, total_since_start
from sim.engine.systems.sharing import Thread
from sim.parameters.chute import negligible_acceleration
from sim.parameters.spheres import SKIN, SphereParameters
from sim.parameters.variables import HISTORY, parts, recorded_by

#: Most particle-steps between two pauses: some tenths of a second.
MOST_WORK = 4_000_000

#: States of the path that ends a run.
PATH_STATES = 41


class _Kernels:
    """Compiled functions that samples of flows with these laws and this drive call."""

    def __init__(self, laws: tuple[NamedTuple, NamedTuple], drive: NamedTuple):
        kind = kind_of(laws, drive)
        self.advance = DirectCall(leap_frog.advance_spheres, kind)
        self.stored_in_spheres = DirectCall(stored_in_spheres, kind)
        self.stored_in_plane = DirectCall(stored_in_plane, kind)
        self.add_sample = DirectCall(add_sample, kind)
        self.count_overlaps = DirectCall(count_overlaps, kind)
        self.add_contacts = DirectCall(add_contacts, kind)
        self.list_contacts = DirectCall(list_contacts, kind)


class Chute:
    """One replicate of a chute flow in motion."""

    ledger = CHUTE_LEDGER
    axes = ("x", "y", "z")
    state_names: tuple[str, ...] = (
        *("spheres", "pairs", "plane", "memory", "scratch", "flow"),
        *("travelled", "lost", "work_done"),
    )

    #: Moment of inertia over m r², infinite without rotation; weight of particles in slices; and
    #: the time, in units of the system, from one state of the path to the next.
    inertia, profile_weight, path_interval = SOLID, VOLUME, 0.1

    def __init__(self, parameters: SphereParameters, replicate: int, substeps: int = 1):
        self.parameters = p = parameters
        self.pause, self.stage = no_pause, ""
        self.series = recorded_by(p, "series")
        self.substeps = substeps
        self.time_step = p.time_step / substeps
        self.sample_steps = p.sample_steps * substeps
        self.box = self._box()
        angle = radians(p.angle)
        self.gravity = (p.gravity * sin(angle), 0.0, -p.gravity * cos(angle))
        self.drive = self._drive()
        layer = self._layer(replicate)
        number = len(layer.radius)
        self.spheres = make_spheres(*layer[:4], p.threads, p.orientations)
        self.pairs = empty_pair_list(layer.radius, self.box, SKIN * p.diameter)
        self.laws = (self._law(p.friction, 0.5 * p.mass), self._law(p.friction_plane, p.mass))
        self.plane = make_plane(self.laws[1], number, p.threads)
        self.memory = make_memory(self.laws[0], len(self.pairs.touching))
        self.team = Team(p.threads)
        self.scratch = [make_scratch() for _ in range(p.threads)]
        self.glued = number - p.particles
        self.flow = leap_frog.make_flow(number, p.threads, fixed=self.glued > 0)
        slice_height = p.slice_height * p.diameter
        self.slices = FlowProfiles(
            ceil((1.5 * layer.height + 10.0 * p.diameter) / slice_height),
            slice_height,
            area=self._base_area(),
            gravity=-self.gravity[2],
            diameter=p.diameter,
            density=p.mass / (pi / 6.0 * p.diameter**3),
            stress=p.stress_profiles,
        )
        self.scales = self._scales()
        self.mass = float(self.spheres.mass.sum())
        self.weight = (self.mass * self.gravity[0], -self.mass * self.gravity[2])
        self.period = 1
        self.profile_height = self.slices.height()
        self.history_profiles = (
            tuple(parts(HISTORY, p.system).values()) if p.stress_profiles else ()
        )
        self._stretch = max(1, int(MOST_WORK // max(number, p.effective_particles)))
        self.loop_time, self._kernels = 0.0, _Kernels(self.laws, self.drive)
        self.travelled, self.lost, self.work_done = 0.0, 0.0, 0.0
        self.coordinates = {
            "overlap_edges": ("1", "edges of the intervals of overlap, in diameters", EDGES),
            "path_time": (
                "s",
                "time since the path began",
                np.arange(PATH_STATES) * self._path_steps() * self.time_step,
            ),
        }

    def _box(self) -> Box:
        side = self.parameters.cell * self.parameters.diameter
        return make_box(side, side)

    def _layer(self, replicate: int) -> Layer:
        return initial_layer(self.parameters, self.box, replicate)

    def _base_area(self) -> float:
        """Return the area of the cell (m²), to which packing fractions refer."""
        return self.box.length[0] * self.box.length[1]

    def _drive(self) -> NamedTuple:
        return Gravity(self.gravity)

    def _scales(self) -> Scales:
        p = self.parameters
        negligible = negligible_acceleration(p.gravity, p.angle)
        return Scales(
            1e-3 * p.velocity_unit, acceleration=negligible, drift=p.drift, target=p.target
        )

    def _path_steps(self) -> int:
        """Return the time steps from one state of the path to the next."""
        interval = self.path_interval * self.parameters.time_unit
        return max(1, round(interval / self.parameters.time_step)) * self.substeps

    def _law(self, friction: float, reduced_mass: float) -> NamedTuple:
        return law_of(self.parameters, Partners(friction, reduced_mass, self.time_step))

    def settle(self) -> None:
        """Do nothing: flows on a plane start from their initial state."""

    def take_over(self, other: "Chute") -> None:
        """Continue with the spheres of another flow and the memory of their contacts."""
        for name in ("spheres", "pairs", "plane", "memory", "scratch", "flow"):
            setattr(self, name, getattr(other, name))
        self.flow.sums[:] = 0.0

    def sample(self, most: int = 1, profiles: bool = False) -> Samples:
        """Advance by one to ``most`` samples and return their values and profiles."""
        count, states = min(most, max(1, self._stretch // self.sample_steps)), []
        sums = tuple(zero_samples(count, part) for part in self.no_profiles()) if profiles else None
        try:
            for k in range(count):
                self._finish_sample()
                states.append(self._state())
                if sums:
                    self._add_profiles(sums, k)
        except BlowUp as error:
            raise BlowUp(str(error), self._samples(states, sums) if states else None) from None
        return self._samples(states, sums)

    def _samples(self, states: list[tuple[float, ...]], sums: Sums | None) -> Samples:
        """Return the samples of S states, with the first S of the sums of profiles."""
        values = self._values(np.array(states).T)
        return Samples(values, sums and tuple(first_samples(part, len(states)) for part in sums))

    def advance(self) -> dict[str, float]:
        """Advance by one sample and return a value per time series."""
        return self.sample().first()

    def _finish_sample(self) -> None:
        """Advance to the end of the sample under way, or of the next one."""
        steps_done = int(self.flow.sums[leap_frog.STEPS])
        if 0 < steps_done < self.sample_steps:
            self._advance_steps(self.sample_steps - steps_done)
        else:
            self._run(self.sample_steps)

    def _run(self, steps: int) -> None:
        """Advance by a number of steps, with the sums of these steps alone."""
        self.flow.sums[:] = 0.0
        self._advance_steps(steps)

    def _advance_steps(self, steps: int) -> None:
        """Advance by a number of steps, with pauses on the way."""
        last = self.flow.step[0] + steps
        while self.flow.step[0] < last:
            self._advance_to(min(last, self.flow.step[0] + self._stretch))
            if self.flow.step[0] < last:
                self.pause()

    def _advance_to(self, target: int) -> None:
        flow = self.flow
        start_time, status = working_time(), LIST_FULL
        while status == LIST_FULL:
            status = self.team.run(partial(self._advance, target - flow.step[0]))
            if status == LIST_FULL:
                self.pairs = double_room(self.pairs)
                self.memory = enlarge_memory(self.memory, len(self.pairs.touching))
        self.loop_time += working_time() - start_time
        if reason := failure_reason(status, self.spheres.position):
            time = flow.step[0] * self.time_step / self.parameters.time_unit
            raise BlowUp(f"{reason} at step {flow.step[0]} (t* = {time:.4g})")

    def _contacts(self) -> leap_frog.FlowContacts:
        return leap_frog.FlowContacts(self.laws, self.pairs, self.plane, self.memory)

    def _advance(self, steps: int, rank: int) -> int:
        limit = self.parameters.overlap_limit
        motion = leap_frog.Motion(self.drive, self.time_step, limit, self.inertia)
        thread = Thread(rank, self.team.gate, self.scratch[rank])
        return self._kernels.advance(
            self.spheres, self._contacts(), self.flow, motion, thread, steps
        )

    def _state(self) -> tuple[float, ...]:
        """Return the numbers of a sample: sums over its steps, energies, energies in springs."""
        spheres, time_step, step = self.spheres, self.time_step, self.flow.step[0] % 2
        kernels, plane = self._kernels, self.plane
        return (
            *self.flow.sums.tolist(),
            *flow_energies(spheres.position, spheres.velocity, spheres.rim, spheres.mass),
            *kernels.stored_in_spheres(
                self.laws[0], spheres, self.pairs, self.memory[step], time_step
            ),
            *kernels.stored_in_plane(self.laws[1], spheres, plane, plane.memory[step], time_step),
        )

    def _values(self, states: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values (S,) of each time series from states (K, S), see ``_state``.

        The work done against friction is stored or lost.
        """
        sums, (kinetic, rotational, height, *stored) = np.split(states, [leap_frog.SUMS])
        normal, tangential = stored[0] + stored[2], stored[1] + stored[3]
        mean = sums / sums[leap_frog.STEPS]
        velocity = mean[leap_frog.MOMENTUM] / self.mass
        displacement = sums[leap_frog.MOMENTUM] / self.mass * self.time_step
        along = self.gravity[0] * total_since_start(self, "travelled", displacement)
        across = -self.gravity[2] * height
        work = total_since_start(self, "work_done", sums[leap_frog.FRICTION_WORK])
        inertia = self.inertia if isfinite(self.inertia) else 0.0
        return {
            "mean_velocity": velocity,
            "mass_flux": velocity * self.mass / self.box.length[0] ** 2,
            "kinetic_energy": 0.5 * kinetic,
            "rotational_energy": 0.5 * inertia * rotational,
            "potential_energy": self.mass * (across - along),
            "stored_energy": normal + tangential,
            "normal_loss": total_since_start(self, "lost", sums[leap_frog.NORMAL_LOSS]),
            "frictional_loss": work - tangential,
            "height_of_mass": height,
            "contact_number": mean[leap_frog.CONTACTS] / self.parameters.particles,
            "largest_overlap": sums[leap_frog.LARGEST],
            "base_normal_force": mean[leap_frog.PLANE_Z],
            "base_shear_force": -mean[leap_frog.PLANE_X],
        }

    def no_profiles(self) -> Sums:
        """Return sums of zero: the profile, the overlaps and those requested."""
        return self.slices.empty()

    def _add_profiles(self, sums: Any, k: int) -> None:
        """Add the present state to the sums of sample k."""
        spheres, slice_height = self.spheres, self.slices.slice_height
        height, radius, velocity = spheres.position[2], spheres.radius, spheres.velocity
        rim = spheres.rim[1:2]
        if self.glued:
            mobile = spheres.mass > 0.0
            height, radius, velocity = height[mobile], radius[mobile], velocity[:, mobile].copy()
            rim = rim[:, mobile]
        profile, overlaps, *contact_sums = (
            type(part)(*(array[k] for array in part)) for part in sums
        )
        self._kernels.add_sample(
            profile, self.profile_weight, slice_height, height, radius, velocity
        )
        self._kernels.count_overlaps(overlaps.counts, spheres, self.pairs)
        if contact_sums:
            spin, *stress_and_slip = contact_sums
            self._kernels.add_sample(spin, VOLUME, slice_height, height, radius, rim / radius)
            target = ContactSums(*stress_and_slip)
            self._kernels.add_contacts(target, spheres, self._contacts(), self._sampling())

    def _sampling(self) -> Sampling:
        """Return the settings for forces of contacts: step, slice height, time step, frictions."""
        p = self.parameters
        friction = p.friction, p.friction_plane
        return Sampling(int(self.flow.step[0]), self.slices.slice_height, self.time_step, friction)

    def current_contacts(self, most: int) -> ContactList:
        """Return the contacts of the present state, listed if there are at most ``most``."""
        contacts = no_contacts(most)
        self._kernels.list_contacts(contacts, self.spheres, self._contacts(), self._sampling())
        return contacts

    def profiles(self, sums: Any) -> dict[str, np.ndarray]:
        """Return velocity, packing fraction and granular temperature per slice."""
        return self.slices.profiles(sums[0])

    def tables(self, sums: Any) -> dict[str, np.ndarray]:
        """Return the histogram of overlaps and, if requested, profiles of contacts and rheology."""
        return self.slices.tables(*sums)

    def trace(self) -> np.ndarray:
        """Advance for a while and return the path of every sphere (S, N, 3) in m, unwrapped."""
        states = [self._initial_order(self.spheres.position)]
        for _ in range(PATH_STATES - 1):
            self._run(self._path_steps())
            mean_displacement = self.flow.sums[leap_frog.MOMENTUM] / self.mass * self.time_step
            states.append(self._initial_order(self.spheres.position))
            # Between two states a sphere may pass through half a cell with the flow, but not
            # against it.
            stray = states[-1] - states[-2] - [mean_displacement, 0.0, 0.0]
            for d, length in enumerate(self.box.length[:2]):
                states[-1][:, d] -= length * np.round(stray[:, d] / length)
        return np.array(states)

    def _initial_order(self, vectors: np.ndarray) -> np.ndarray:
        """Return vectors (3, N) of the particles as (N, 3) in the initial order."""
        return vectors.T[np.argsort(self.spheres.label[0])]

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return positions, velocities, spins, radii and orientations, in the initial order."""
        spheres = self.spheres
        place = np.argsort(spheres.label[0])
        glued = {"fixed": (spheres.mass[place] == 0.0).astype(int)} if self.glued else {}
        return glued | {
            "position": spheres.position.T[place],
            "particle_velocity": spheres.velocity.T[place],
            "particle_spin": (spheres.rim / spheres.radius).T[place],
            "radius": spheres.radius[place],
            "orientation": spheres.orientation.T[place[: spheres.orientation.shape[1]]],
        }
