"""Walton's inclined chute: spheres, Walton-Braun contacts, a frictional plane, leap-frog."""

from functools import partial
from math import ceil, cos, radians, sin
from typing import NamedTuple

import numpy as np

from sim.engine.boundary.plane import make_plane, stored_in_plane
from sim.engine.contact import Partners, law_of
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.neighbors import empty_pair_list, grown
from sim.engine.dynamics.spheres import (
    SOLID,
    enlarged,
    make_memory,
    make_scratch,
    make_spheres,
    stored_in_spheres,
)
from sim.engine.dynamics.status import LIST_FULL, require_motion
from sim.engine.dynamics.team import Team
from sim.engine.observe.overlaps import EDGES, Overlaps, count_overlaps, no_overlaps
from sim.engine.observe.profiles import VOLUME, Profile, add_sample, empty_profile
from sim.engine.observe.regime import Scales
from sim.engine.systems import leap_frog
from sim.engine.systems.chute_start import initial_layer
from sim.engine.systems.series import CHUTE_LEDGER, CHUTE_SERIES
from sim.engine.systems.sharing import Thread
from sim.parameters import ChuteParameters
from sim.parameters.chute import negligible_acceleration

#: Skin of the neighbor list in diameters.
SKIN = 0.2

#: States of the path that ends a run, and the time (√(σ/g)) from one to the next.
PATH_STATES, PATH_INTERVAL = 41, 0.1


class Chute:
    """One replicate of a chute flow in motion."""

    series = CHUTE_SERIES
    ledger = CHUTE_LEDGER
    axes = ("x", "y", "z")
    moving = (
        *("spheres", "pairs", "plane", "memory", "scratch", "flow"),
        *("travelled", "lost", "work_done"),
    )

    def __init__(self, parameters: ChuteParameters, replicate: int, substeps: int = 1):
        self.parameters = p = parameters
        self.substeps = substeps
        self.time_step = p.time_step / substeps
        self.sample_steps = p.sample_steps * substeps
        side = p.cell * p.diameter
        self.box = make_box(side, side)
        layer = initial_layer(p, self.box, replicate)
        number = len(layer.radius)
        self.spheres = make_spheres(*layer[:4], p.threads, p.orientations)
        self.pairs = empty_pair_list(layer.radius, self.box, SKIN * p.diameter)
        self.plane = make_plane(number, p.threads)
        self.memory = make_memory(len(self.pairs.touching))
        self.team = Team(p.threads)
        self.scratch = [make_scratch() for _ in range(p.threads)]
        self.glued = number - p.particles
        self.flow = leap_frog.make_flow(number, p.threads, fixed=self.glued > 0)
        self.laws = (self._law(p.friction, 0.5 * p.mass), self._law(p.friction_plane, p.mass))
        angle = radians(p.angle)
        self.gravity = (p.gravity * sin(angle), 0.0, -p.gravity * cos(angle))
        self.slice_height = p.slice_height * p.diameter
        slices = ceil((1.5 * layer.height + 10.0 * p.diameter) / self.slice_height)
        negligible = negligible_acceleration(p.gravity, p.angle)
        self.scales = Scales(
            1e-3 * p.velocity_unit, acceleration=negligible, drift=p.drift, target=p.target
        )
        self.mass = float(self.spheres.mass.sum())
        self.weight = (self.mass * self.gravity[0], -self.mass * self.gravity[2])
        self.period = 1
        self.profile_height = (np.arange(slices) + 0.5) * self.slice_height
        self.travelled, self.lost, self.work_done = 0.0, 0.0, 0.0
        self.coordinates = {
            "overlap_edges": ("1", "edges of the intervals of overlap, in diameters", EDGES),
            "path_time": (
                "s",
                "time since the path began",
                np.arange(PATH_STATES) * self._path_steps() * self.time_step,
            ),
        }

    def _path_steps(self) -> int:
        """Return the time steps from one state of the path to the next."""
        interval = PATH_INTERVAL * self.parameters.time_unit
        return max(1, round(interval / self.parameters.time_step)) * self.substeps

    def _law(self, friction: float, reduced_mass: float) -> NamedTuple:
        return law_of(self.parameters, Partners(friction, reduced_mass, self.time_step))

    def settle(self) -> None:
        """Do nothing: the paper's flow starts from its initial state."""

    def advance(self) -> dict[str, float]:
        """Advance by one sample interval and return a value per time series."""
        self._run(self.sample_steps)
        return self._sample()

    def _run(self, steps: int) -> None:
        """Advance by a number of steps, with the sums of these steps alone."""
        flow = self.flow
        flow.sums[:] = 0.0
        target = flow.step[0] + steps
        status = LIST_FULL
        while status == LIST_FULL:
            status = self.team.run(partial(self._advance, target - flow.step[0]))
            if status == LIST_FULL:
                self.pairs = grown(self.pairs)
                self.memory = enlarged(self.memory, len(self.pairs.touching))
        time = flow.step[0] * self.time_step / self.parameters.time_unit
        require_motion(status, self.spheres.position, f"{flow.step[0]} (t* = {time:.4g})")

    def _advance(self, steps: int, rank: int) -> int:
        contacts = leap_frog.FlowContacts(self.laws, self.pairs, self.plane, self.memory)
        motion = leap_frog.Motion(self.gravity, self.time_step, self.parameters.overlap_limit)
        thread = Thread(rank, self.team.gate, self.scratch[rank])
        return leap_frog.advance_spheres(self.spheres, contacts, self.flow, motion, thread, steps)

    def _sample(self) -> dict[str, float]:
        spheres, sums = self.spheres, self.flow.sums
        mean = sums / sums[leap_frog.STEPS]
        velocity = mean[leap_frog.MOMENTUM] / self.mass
        speed = (spheres.velocity**2).sum(axis=0)
        rim = (spheres.rim**2).sum(axis=0)
        height = np.average(spheres.position[2], weights=spheres.mass)
        return {
            "mean_velocity": velocity,
            "mass_flux": velocity * self.mass / self.box.length[0] ** 2,
            "kinetic_energy": 0.5 * (spheres.mass * speed).sum(),
            "rotational_energy": 0.5 * SOLID * (spheres.mass * rim).sum(),
            **self._ledger(height),
            "height_of_mass": height,
            "contact_number": mean[leap_frog.CONTACTS] / self.parameters.particles,
            "largest_overlap": sums[leap_frog.LARGEST],
            "base_normal_force": mean[leap_frog.PLANE_Z],
            "base_shear_force": -mean[leap_frog.PLANE_X],
        }

    def _ledger(self, height: float) -> dict[str, float]:
        """Return where the energy is and has gone; a friction's work is stored or lost."""
        spheres, sums, step = self.spheres, self.flow.sums, self.flow.step[0] % 2
        self.travelled += sums[leap_frog.MOMENTUM] / self.mass * self.time_step
        self.lost += sums[leap_frog.NORMAL_LOSS]
        self.work_done += sums[leap_frog.FRICTION_WORK]
        pairs = stored_in_spheres(
            self.laws[0], spheres, self.pairs, self.memory[step], self.time_step
        )
        plane = stored_in_plane(
            self.laws[1], spheres, self.plane, self.plane.memory[step], self.time_step
        )
        normal, tangential = pairs[0] + plane[0], pairs[1] + plane[1]
        along, across = self.gravity[0] * self.travelled, -self.gravity[2] * height
        return {
            "potential_energy": self.mass * (across - along),
            "stored_energy": normal + tangential,
            "normal_loss": self.lost,
            "frictional_loss": self.work_done - tangential,
        }

    def sample_profiles(self) -> tuple[Profile, Overlaps]:
        """Return the profile of the present state, weighted by volume, and its overlaps."""
        profile = empty_profile(len(self.profile_height), 3)
        spheres = self.spheres
        height, radius, velocity = spheres.position[2], spheres.radius, spheres.velocity
        if self.glued:
            moving = spheres.mass > 0.0
            height, radius, velocity = height[moving], radius[moving], velocity[:, moving].copy()
        add_sample(profile, VOLUME, self.slice_height, height, radius, velocity)
        overlaps = no_overlaps()
        count_overlaps(overlaps.counts, spheres, self.pairs)
        return profile, overlaps

    def profiles(self, sums: tuple[Profile, Overlaps]) -> dict[str, np.ndarray]:
        """Return velocity, packing fraction and granular temperature per slice."""
        profile, _ = sums
        slab = self.box.length[0] * self.box.length[1] * self.slice_height
        temperature = profile.temperature()
        return {
            "velocity_profile": profile.velocity(),
            "packing_profile": profile.weight / (slab * profile.samples[0]),
            "granular_temperature_profile": temperature.mean(axis=1),
            "vertical_temperature_profile": temperature[:, 2],
        }

    def tables(self, sums: tuple[Profile, Overlaps]) -> dict[str, np.ndarray]:
        """Return how many contacts overlapped by how much."""
        return {"overlap_histogram": sums[1].counts}

    def trace(self) -> np.ndarray:
        """Go on for a while and return the path of every sphere (S, N, 3) in m, unwrapped."""
        states = [self._in_order(self.spheres.position)]
        for _ in range(PATH_STATES - 1):
            self._run(self._path_steps())
            moved = self.flow.sums[leap_frog.MOMENTUM] / self.mass * self.time_step
            states.append(self._in_order(self.spheres.position))
            # Between two states a sphere may pass through half a cell with the flow, but not
            # against it.
            stray = states[-1] - states[-2] - [moved, 0.0, 0.0]
            for d, length in enumerate(self.box.length[:2]):
                states[-1][:, d] -= length * np.round(stray[:, d] / length)
        return np.array(states)

    def _in_order(self, vectors: np.ndarray) -> np.ndarray:
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
