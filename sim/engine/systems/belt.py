"""The vibrating belt of Gallas, Herrmann and Sokolowski: beads on a line that shakes."""

from math import pi, radians, sqrt

import numpy as np

from sim.engine.boundary.belt import belt_height, stored_in_belt
from sim.engine.boundary.obstacle import Obstacle, stored_in_obstacle
from sim.engine.contact.spring_damping import spring_damping
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.disks import make_disks, stored_in_disks
from sim.engine.dynamics.gear import Gear, Verlet, restarted
from sim.engine.dynamics.neighbors import empty_pair_list, grown, make_search
from sim.engine.dynamics.status import LIST_FULL, BlowUp, require_motion
from sim.engine.observe.field import Field, squares, wave_power
from sim.engine.observe.profiles import AREA, CENTRE, Profile, add_sample, empty_profile
from sim.engine.observe.regime import Scales
from sim.engine.systems import shaking
from sim.engine.systems.belt_start import initial_bed, vibration
from sim.engine.systems.series import BELT_LEDGER, BELT_SERIES
from sim.parameters import BeltParameters

#: Skin of the neighbor list in mean diameters.
SKIN = 0.3

#: Slices of the profiles, one mean diameter each.
SLICES = 80

#: Intervals of the path over the cycle that ends a run: the paper plots every 50th of 2000 steps.
PATH_INTERVALS = 40

#: Simulated time (s) after which a bed that still moves is given up.
SETTLING_LIMIT = 30.0


class Belt:
    """One replicate of beads on the belt in motion."""

    series = BELT_SERIES
    ledger = BELT_LEDGER
    axes = ("x", "z")
    moving = ("disks", "pairs", "search", "loop", "normal_loss", "shear_loss", "belt_work")

    def __init__(self, parameters: BeltParameters, replicate: int, substeps: int = 1):
        self.parameters = p = parameters
        self.time_step = p.time_step / substeps
        self.settling_step = p.settling_step / substeps
        self.steps_per_cycle = p.steps_per_cycle * substeps
        self.sample_steps = p.sample_steps * substeps
        width = p.width * p.diameter
        self.box = make_box(width)
        bed = initial_bed(p, self.box, replicate)
        self.fall_time = sqrt(2.0 * (bed.height + p.diameter) / p.gravity)
        self.disks = make_disks(
            bed.position, np.zeros_like(bed.position), bed.radius, bed.mass, self.settling_step
        )
        self.pairs = empty_pair_list(bed.radius, self.box, SKIN * p.diameter)
        self.search = make_search(p.beads)
        self.law = spring_damping(
            p.stiffness * p.gravity * p.mass / p.diameter,
            p.damping * p.gravity,
            p.shear_damping * p.gravity,
            p.damping_mass,
            p.attraction,
        )
        self.obstacle = Obstacle(
            x=0.5 * width,
            z=p.amplitude * p.diameter,
            radius=0.5 * p.obstacle * p.diameter,
        )
        self.belt = vibration(p, p.frequency)
        self.integrator = self._integrator(self.time_step)
        self.loop = shaking.make_shaking()
        self.scales = Scales(p.least_transport, acceleration=np.inf, drift=p.drift, target=p.target)
        self.mass = float(bed.mass.sum())
        self.period = p.samples_per_cycle
        self.profile_height = (np.arange(SLICES) + 0.5) * p.diameter
        self.normal_loss, self.shear_loss, self.belt_work = 0.0, 0.0, 0.0
        self.squares = squares(width, p.diameter, p.amplitude)
        self.coordinates = self.squares.coordinates() | {
            "path_time": (
                "s",
                "time since the path began, at the initial phase of the belt",
                np.linspace(0.0, p.time_unit, PATH_INTERVALS + 1),
            ),
        }

    def _integrator(self, time_step: float):
        kind = {"gear": Gear, "verlet": Verlet}[self.parameters.integrator]
        return kind(float(time_step))

    def settle(self) -> None:
        """Let the beads fall onto the resting belt until their mean squared velocity is small."""
        p, step = self.parameters, self.settling_step
        belt, integrator = vibration(p, 0.0), self._integrator(step)
        stretch = max(1, int(self.fall_time / step))
        squared = np.inf
        while squared >= p.settle_velocity_squared:
            if self.loop.step[0] * step > SETTLING_LIMIT:
                raise BlowUp(
                    f"the bed is not at rest after {SETTLING_LIMIT:g} s: mean squared velocity "
                    f"{squared:.3g} m2/s2, wanted {p.settle_velocity_squared:g}"
                )
            self._run(integrator, belt, stretch, "while the bed settles")
            self._stop_free_drift()
            squared = float(((self.disks.taylor[1] / step) ** 2).sum(axis=0).mean())
            stretch = max(1, int(0.01 / step))
        if p.prior_frequency > 0.0:
            step = self._shake_before(step)
        restarted(self.disks.taylor, step, self.time_step)
        self.disks.taylor[1, 0] += p.initial_velocity * p.velocity_unit * self.time_step
        self.loop = shaking.make_shaking()

    def _shake_before(self, step: float) -> float:
        """Shake at the prior frequency for whole cycles; return the time step used."""
        p = self.parameters
        prior_step = 1.0 / (p.prior_frequency * self.steps_per_cycle)
        restarted(self.disks.taylor, step, prior_step)
        self.loop = shaking.make_shaking()
        before = vibration(p, p.prior_frequency)
        for _ in range(p.prior_cycles):
            where = "of the shaking at the prior frequency"
            self._run(self._integrator(prior_step), before, self.steps_per_cycle, where)
        return prior_step

    def _stop_free_drift(self) -> None:
        """Take the bed's uniform drift out where nothing else would: on a belt without friction.

        Damping by each bead's own mass does not conserve momentum, so a settling bed picks up a
        drift along the belt, which only the shear damping of the belt would stop.
        """
        if self.parameters.shear_damping == 0.0:
            self.disks.taylor[1, 0] -= self.disks.taylor[1, 0].mean()

    def _run(self, integrator, belt, steps: int, where: str) -> None:
        p, loop = self.parameters, self.loop
        motion = shaking.BedMotion(integrator, p.gravity, p.overlap_limit)
        target = loop.step[0] + steps
        status = LIST_FULL
        while status == LIST_FULL:
            contacts = shaking.BedContacts(self.law, self.pairs, belt, self.obstacle, self.search)
            remaining = target - loop.step[0]
            status = shaking.advance_disks(self.disks, contacts, loop, motion, remaining)
            if status == LIST_FULL:
                self.pairs = grown(self.pairs)
        require_motion(status, self.disks.taylor, f"{loop.step[0]} {where}")

    def advance(self) -> dict[str, float]:
        """Advance by one sample interval and return a value per time series."""
        self.loop.sums[:] = 0.0
        self._run(self.integrator, self.belt, self.sample_steps, "of the shaking")
        return self._sample()

    def _time(self) -> float:
        return self.loop.step[0] * self.time_step

    def _velocity(self) -> np.ndarray:
        return self.disks.taylor[1] / self.time_step

    def _sample(self) -> dict[str, float]:
        p, disks, sums = self.parameters, self.disks, self.loop.sums
        mean = sums / sums[shaking.STEPS]
        cycle_step = self.loop.step[0] % self.steps_per_cycle
        angle = 2.0 * pi * cycle_step / self.steps_per_cycle + radians(p.phase)
        return {
            "mean_velocity": mean[shaking.VELOCITY],
            "mass_flux": mean[shaking.MOMENTUM] / self.box.length[0],
            "kinetic_energy": 0.5 * (disks.mass * (self._velocity() ** 2).sum(axis=0)).sum(),
            **self._ledger(),
            "height_of_mass": np.average(disks.taylor[0, 1], weights=disks.mass),
            "contact_number": mean[shaking.CONTACTS] / p.beads,
            "largest_overlap": sums[shaking.LARGEST],
            "belt_phase": angle % (2.0 * pi),
            **self._places(),
        }

    def _places(self) -> dict[str, float]:
        """Return measures of where the beads are: near the belt, and in waves along it."""
        x, z = self.disks.taylor[0]
        near = np.abs(z) < self.parameters.amplitude * self.parameters.diameter
        return {"base_occupancy": near.mean(), "wave_power": wave_power(x, self.box.length[0])}

    def _ledger(self) -> dict[str, float]:
        """Return where the energy is, where it has gone and where it came from."""
        disks, sums = self.disks, self.loop.sums
        self.normal_loss += sums[shaking.NORMAL_LOSS]
        self.shear_loss += sums[shaking.SHEAR_LOSS]
        self.belt_work += sums[shaking.BELT_WORK]
        stored = (
            stored_in_disks(self.law, disks, self.pairs)
            + stored_in_belt(self.law, disks, self.belt, self._time())
            + stored_in_obstacle(self.law, disks, self.obstacle, self.box)
        )
        return {
            "potential_energy": self.parameters.gravity * float(disks.mass @ disks.taylor[0, 1]),
            "stored_energy": stored,
            "normal_loss": self.normal_loss,
            "shear_loss": self.shear_loss,
            "belt_work": self.belt_work,
        }

    def sample_profiles(self) -> tuple[Profile, Profile, Field]:
        """Return profiles above the present belt, by centres and by area, and the field."""
        height = self.disks.taylor[0, 1] - belt_height(self.belt, self._time())
        profiles = []
        for kind in (CENTRE, AREA):
            profile = empty_profile(SLICES, 2)
            add_sample(
                profile,
                kind,
                self.parameters.diameter,
                height,
                self.disks.radius,
                self._velocity(),
            )
            profiles.append(profile)
        return (*profiles, self.squares.sample(*self.disks.taylor[0], self._velocity()[0]))

    def profiles(self, sums: tuple[Profile, Profile, Field]) -> dict[str, np.ndarray]:
        """Return velocity, densities and granular temperature per slice."""
        centres, area, _ = sums
        slab = self.box.length[0] * self.parameters.diameter
        temperature = centres.temperature()
        return {
            "velocity_profile": centres.velocity(),
            "packing_profile": area.weight / (slab * area.samples[0]),
            "number_density": centres.weight / (slab * centres.samples[0]),
            "granular_temperature_profile": temperature.mean(axis=1),
            "vertical_temperature_profile": temperature[:, 1],
        }

    def tables(self, sums: tuple[Profile, Profile, Field]) -> dict[str, np.ndarray]:
        """Return mean velocity and density in squares of the laboratory."""
        return self.squares.tables(sums[2])

    def trace(self) -> np.ndarray:
        """Finish the cycle and return the path of every bead (S, N, 2) in m over one more."""
        steps = self.steps_per_cycle
        self._run(self.integrator, self.belt, -self.loop.step[0] % steps, "of the last cycle")
        states = [self._in_order(self.disks.taylor[0])]
        for k in range(PATH_INTERVALS):
            interval = (k + 1) * steps // PATH_INTERVALS - k * steps // PATH_INTERVALS
            self._run(self.integrator, self.belt, interval, "of the path")
            states.append(self._in_order(self.disks.taylor[0]))
            moved = states[-1][:, 0] - states[-2][:, 0]
            states[-1][:, 0] -= self.box.length[0] * np.round(moved / self.box.length[0])
        return np.array(states)

    def _in_order(self, vectors: np.ndarray) -> np.ndarray:
        """Return vectors (2, N) of the beads as (N, 2) in the initial order."""
        return vectors.T[np.argsort(self.disks.label[0])]

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return positions, velocities and radii, in the initial order."""
        place = np.argsort(self.disks.label[0])
        return {
            "position": self.disks.taylor[0].T[place],
            "particle_velocity": self._velocity().T[place],
            "radius": self.disks.radius[place],
        }
