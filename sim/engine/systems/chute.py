"""Spheres or discs on a frictional plane, by leap-frog, and Walton's chute among them.

`PlaneFlow` has all that chute and conveyor share. On the chute, gravity drives the particles down
a resting plane.
"""

from abc import abstractmethod
from copy import deepcopy
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from sim.engine.boundary.drive import Gravity, constant_gravity, tilt_after, tilt_of
from sim.engine.boundary.plane import stored_in_plane
from sim.engine.compile import call_directly
from sim.engine.contact import Partners, law_of
from sim.engine.contact.friction import memory_after, restart_memory
from sim.engine.dynamics.cells import BlowUp, make_box
from sim.engine.dynamics.spheres import SOLID, make_spheres, stored_in_spheres
from sim.engine.observe.contacts import ContactSums, Sampling, add_contacts, list_contacts
from sim.engine.observe.profiles import (
    AREA,
    EDGES,
    VOLUME,
    add_sample,
    count_overlaps,
    flow_energies,
)
from sim.engine.observe.regime import Scales
from sim.engine.observe.samples import (
    ContactList,
    Samples,
    first_samples,
    make_ledger,
    zero_samples,
)
from sim.engine.systems import leap_frog
from sim.engine.systems.moving import MovingSpheres
from sim.engine.systems.replica import PATH_INTERVALS, Replica
from sim.engine.systems.slices import flow_profiles
from sim.engine.systems.start import initial_layer
from sim.parameters import ChuteParameters
from sim.parameters.chute import negligible_acceleration
from sim.parameters.given import given_particles
from sim.parameters.spheres import SKIN, SphereParameters
from sim.parameters.variables import HISTORY, parts

#: Moment of inertia of a disc over m r².
DISC = 0.5

#: Breadth of the cell of discs in their largest diameters: no disc meets its own image.
BREADTH = 3.0

#: Terms of the energy ledger.
LOSSES = ("normal_loss", "frictional_loss")
TERMS = ("kinetic_energy", "rotational_energy", "potential_energy", "stored_energy", *LOSSES)

#: The numbers of a sample by name, or those of K samples, with a first axis over them.
State = dict[str, Any]


class PlaneFlow(MovingSpheres, Replica):
    """One replicate of particles on a plane; positions and velocities are relative to the plane.

    A concrete flow adds its drive, its scales and the length of its path.
    """

    parameters: SphereParameters
    ledger = make_ledger(*TERMS, turnover=LOSSES)
    axes = ("x", "y", "z")
    particle_names = ("spheres", "pairs", "plane", "memory", "scratch", "flow")
    state_names: tuple[str, ...] = (*particle_names, "travelled", "lost", "work_done")

    def __init__(
        self, parameters: SphereParameters, replicate: int, substeps: int, path_interval: float
    ):
        super().__init__(parameters, substeps)
        p, length = parameters, parameters.cell * parameters.diameter
        if p.is_flat:
            largest = p.diameter * (1 + p.diameter_spread)
            if p.initial_state:
                largest = 2.0 * float(given_particles(p).radius.max())
            breadth = BREADTH * max(largest, p.bumps * p.diameter) + p.law_reach
            self.inertia, self._profile_weight, area = DISC, AREA, length
        else:
            breadth = p.breadth * p.diameter
            self.inertia, self._profile_weight, area = SOLID, VOLUME, length * breadth
        box, self.overlap_limit = make_box(length, breadth), p.overlap_limit
        layer = initial_layer(p, box, replicate)
        spheres = make_spheres(*layer[:4], p.threads, p.orientations)
        if layer.spin is not None:
            spheres.rim[:] = layer.spin.T * layer.radius
        laws = (self._law(p.friction, 0.5 * p.mass), self._law(p.friction_plane, p.mass))
        self.gravity = constant_gravity(p, p.angle)
        self.tilt = tilt_of(p, self.sample_steps)
        if self.tilt:
            self.ledger = make_ledger(*self.ledger.terms, "tilt_work", turnover=LOSSES)
            self.state_names = (*self.state_names, "centre", "slope_work", "tilt_work")
        self.set_up(spheres, laws, self._drive(), box, SKIN * p.diameter, p.law_reach)
        self.slices = flow_profiles(p, layer.height, area, -self.gravity[2])
        if p.stress_profiles:
            self.history_profiles = tuple(parts(HISTORY, p.system).values())
        self.mass = float(self.spheres.mass.sum())
        self.weight = (self.mass * self.gravity[0], -self.mass * self.gravity[2])
        self.flux_area = length**2 * (p.breadth / p.cell)
        self.travelled, self.lost, self.work_done = 0.0, 0.0, 0.0
        self.centre, self.slope_work, self.tilt_work = self._centre(), 0.0, 0.0
        interval = max(1, round(path_interval * p.time_unit / p.time_step)) * substeps
        self.path_steps = PATH_INTERVALS * interval
        times = np.arange(PATH_INTERVALS + 1) * interval * self.time_step
        self.coordinates = {
            "overlap_edges": ("1", "edges of the intervals of overlap, in diameters", EDGES),
            "path_time": ("s", "time since the path began", times),
        }

    @abstractmethod
    def _drive(self) -> NamedTuple:
        """Return what sets the flow in motion; its type selects compiled code."""

    def _law(self, friction: float, reduced_mass: float) -> NamedTuple:
        return law_of(self.parameters, Partners(friction, reduced_mass, self.time_step))

    @property
    def loop(self) -> leap_frog.Flow:
        """State of the loop over steps."""
        return self.flow

    def settle(self) -> None:
        """Take given velocities, those at t = 0, back to half a step before, as leap-frog has them.

        Half of what the forces at t = 0 change in a step is left out, with which a free fall is
        exact. Random ones count as those of half a step before.
        """
        super().settle()
        p = self.parameters
        if p.initial_state or p.initial_height or p.initial_normal_velocity:
            change, turn = self._first_changes()
            mobile = self.spheres.mass > 0.0
            self.spheres.velocity[:, mobile] -= 0.5 * change[:, mobile]
            self.spheres.rim[:, mobile] -= 0.5 * turn[:, mobile]

    def _first_changes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return by how much velocities and those of rims (3, N) change in the first step, m/s."""
        before = {name: deepcopy(getattr(self, name)) for name in self.state_names}
        self._run(1)
        order = np.argsort(self.spheres.label[0])
        velocity, rim = (one[:, order] for one in (self.spheres.velocity, self.spheres.rim))
        for name, value in before.items():
            setattr(self, name, value)
        return velocity - self.spheres.velocity + self._frame_change(), rim - self.spheres.rim

    def _frame_change(self) -> np.ndarray:
        """Return the change of the plane's velocity (3, 1) in the first step, m/s."""
        return np.zeros((3, 1))

    def take_over(self, other: Any) -> None:
        """Continue with the particles of another flow and the memory of their contacts."""
        super().take_over(other)
        self.flow.sums[:] = 0.0
        step = self.flow.step[0]
        self.memory = restart_memory(self.memory, step)
        self.plane = self.plane._replace(memory=restart_memory(self.plane.memory, step))
        self.flow.step[0] = 0
        self.centre = self._centre()
        if other.bond != self.bond:
            largest = 2.0 * float(self.spheres.radius.max()) + self.bond.reach
            self.pairs = self.pairs._replace(largest=largest)
            self.pairs.valid[0] = False

    def _take(self, most: int, profiles: bool) -> tuple[Samples | None, str]:
        count, states, failure = min(most, max(1, self._stretch // self.sample_steps)), [], ""
        empty = self.slices.empty() if profiles else ()
        sums = tuple(zero_samples(count, part) for part in empty)
        try:
            for k in range(count):
                self._continue(self._missing_steps())
                states.append(self._state())
                if sums:
                    self._add_profiles(sums, k)
        except BlowUp as error:
            failure = str(error)
        if not states:
            return None, failure
        sums = first_samples(sums, len(states))
        stacked = {name: np.array([one[name] for one in states]) for name in states[0]}
        return Samples(self._values(stacked), sums or None), failure

    def _state(self) -> State:
        """Return the numbers of a sample at its end in the frame of the plane, SI.

        These are the ``sums`` (8,) over its steps, see `leap_frog`; the number of the last
        ``step``; the sums ``translation`` of m v² and ``rotation`` of m times the squared velocity
        of the rim; the mean ``height``; the energies in ``normal`` and ``tangential`` springs.
        """
        spheres, plane, step = self.spheres, self.plane, self.flow.step[0]
        (pair_law, plane_law), time_step = self.laws, self.time_step
        memory, plane_memory = memory_after(self.memory, step), memory_after(plane.memory, step)
        between = pair_law, spheres, self.pairs, memory, time_step
        below = plane_law, spheres, plane, plane_memory, time_step
        pair_normal, pair_tangential = call_directly(stored_in_spheres, self.kind, *between)
        plane_normal, plane_tangential = call_directly(stored_in_plane, self.kind, *below)
        return flow_energies(spheres) | {
            "sums": self.flow.sums.copy(),
            "step": int(step),
            "normal": pair_normal + plane_normal,
            "tangential": pair_tangential + plane_tangential,
        }

    def _values(self, state: State) -> dict[str, np.ndarray]:
        """Return the values (K,) of each time series in the frame of the plane.

        The work done against friction is stored or lost.
        """
        sums, tangential, height = state["sums"].T, state["tangential"], state["height"]
        mean = sums / sums[leap_frog.STEPS]
        velocity = mean[leap_frog.MOMENTUM] / self.mass
        displacement = sums[leap_frog.MOMENTUM] / self.mass * self.time_step
        along = self.gravity[0] * self._total("travelled", displacement)
        across = -self.gravity[2] * height
        work = self._total("work_done", sums[leap_frog.FRICTION_WORK])
        inertia = self.inertia if isfinite(self.inertia) else 0.0
        return {
            "mean_velocity": velocity,
            "mass_flux": velocity * self.mass / self.flux_area,
            "kinetic_energy": 0.5 * state["translation"],
            "rotational_energy": 0.5 * inertia * state["rotation"],
            "potential_energy": self.mass * (across - along),
            "stored_energy": state["normal"] + tangential,
            "normal_loss": self._total("lost", sums[leap_frog.NORMAL_LOSS]),
            "frictional_loss": work - tangential,
            "height_of_mass": height,
            "contact_number": mean[leap_frog.CONTACTS] / self.parameters.particles,
            "largest_overlap": sums[leap_frog.LARGEST],
            "base_normal_force": mean[leap_frog.PLANE_Z],
            "base_shear_force": -mean[leap_frog.PLANE_X],
        }

    def _centre(self) -> float:
        """Return the height of the centre of mass above the plane, m."""
        return float((self.spheres.mass * self.spheres.position[2]).sum() / self.mass)

    def _tilted(self, state: State, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the values (K,) of time series that are others where gravity turns.

        Its direction changes smoothly within a sample: work along x is that of the mean direction.
        """
        if not self.tilt:
            return {}
        steps, height = state["sums"][:, leap_frog.STEPS], values["height_of_mass"]
        before, self.centre = np.array([self.centre, *height[:-1]]), float(height[-1])
        last = state["step"]
        ends = last, last - steps, last - 0.5 * (steps + 1)
        after, at_start, mean = (
            np.array([tilt_after(self.tilt, step) for step in each]).T for each in ends
        )
        way = values["mean_velocity"] * steps * self.time_step
        work = self._total("slope_work", self.mass * mean[1] * way)
        turned = (mean[2] - after[2]) * height - (mean[2] - at_start[2]) * before
        return {
            "angle_now": after[0],
            "potential_energy": -self.mass * after[2] * height - work,
            "tilt_work": self._total("tilt_work", self.mass * turned),
        }

    def _add_profiles(self, sums: Any, k: int) -> None:
        """Add the present state to the sums of sample k."""
        spheres, slice_height = self.spheres, self.slices.slice_height
        height, radius, velocity = spheres.position[2], spheres.radius, spheres.velocity
        rim = spheres.rim[1:2]
        if self.parameters.glued_particles:
            mobile = spheres.mass > 0.0
            height, radius, velocity = height[mobile], radius[mobile], velocity[:, mobile].copy()
            rim = rim[:, mobile]
        profile, overlaps, *contact_sums = (
            type(part)(*(array[k] for array in part)) for part in sums
        )
        weight = self._profile_weight
        kind = self.kind
        call_directly(add_sample, kind, profile, weight, slice_height, height, radius, velocity)
        call_directly(count_overlaps, kind, overlaps.counts, spheres, self.pairs)
        if contact_sums:
            spin, *stress_and_slip = contact_sums
            call_directly(
                add_sample, kind, spin, VOLUME, slice_height, height, radius, rim / radius
            )
            target = ContactSums(*stress_and_slip)
            call_directly(add_contacts, kind, target, spheres, self._contacts(), self._sampling())

    def _sampling(self) -> Sampling:
        """Return the settings for forces of contacts: step, slice height, time step, frictions."""
        p = self.parameters
        friction = p.friction, p.friction_plane
        return Sampling(int(self.flow.step[0]), self.slices.slice_height, self.time_step, friction)

    def _list_contacts(self, contacts: ContactList) -> None:
        arguments = contacts, self.spheres, self._contacts(), self._sampling()
        call_directly(list_contacts, self.kind, *arguments)

    def _mean_displacement(self) -> np.ndarray:
        # Between two states a sphere may pass through half a cell with the flow, but not against
        # it.
        along = self.flow.sums[leap_frog.MOMENTUM] / self.mass * self.time_step
        return np.array([along, 0.0, 0.0])

    def _arrays(self) -> dict[str, np.ndarray]:
        spheres = self.spheres
        fixed = (spheres.mass == 0.0).astype(int)
        return ({"fixed": fixed} if self.parameters.glued_particles else {}) | {
            "label": spheres.label[0],
            "position": spheres.position,
            "particle_velocity": spheres.velocity,
            "particle_spin": spheres.rim / spheres.radius,
            "radius": spheres.radius,
            "orientation": spheres.orientation,
        }

    def _coordinates(self) -> np.ndarray:
        return self.spheres.position

    def _moment(self) -> str:
        time = self.flow.step[0] * self.time_step / self.parameters.time_unit
        return f"(t* = {time:.4g})"


class Chute(PlaneFlow):
    """One replicate of a chute flow in motion."""

    parameters: ChuteParameters

    def __init__(self, parameters: ChuteParameters, replicate: int, substeps: int = 1):
        super().__init__(parameters, replicate, substeps, path_interval=0.1)
        p = parameters
        negligible = negligible_acceleration(p.gravity, p.angle)
        self.scales = Scales(1e-3 * p.velocity_unit, negligible, p.drift, p.target)

    def _drive(self) -> Gravity:
        return Gravity(self.tilt or self.gravity)

    def _values(self, state: State) -> dict[str, np.ndarray]:
        values = super()._values(state)
        return values | self._tilted(state, values)
