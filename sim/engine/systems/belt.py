"""The vibrating belt of Gallas, Herrmann and Sokolowski: beads on a line that shakes."""

from math import pi, radians, sqrt

import numpy as np

from sim.engine.boundary.obstacle import Obstacle
from sim.engine.calls import DirectCall, kind_of
from sim.engine.compile import working_time
from sim.engine.contact.spring_damping import spring_damping
from sim.engine.dynamics.cells import make_box
from sim.engine.dynamics.disks import make_disks
from sim.engine.dynamics.gear import CORRECTORS, Gear, Verlet, rescale_terms
from sim.engine.dynamics.neighbors import double_room, empty_pair_list, make_search
from sim.engine.dynamics.status import LIST_FULL, REASONS, BlowUp, failure_reason
from sim.engine.observe.bed_contacts import list_bed_contacts
from sim.engine.observe.field import squares, wave_power
from sim.engine.observe.regime import Scales
from sim.engine.observe.sums import Sums
from sim.engine.observe.system import ContactList, Samples, no_contacts, no_pause
from sim.engine.systems import bed_samples, shaking
from sim.engine.systems.bed_profiles import bed_profiles
from sim.engine.systems.belt_start import initial_bed, vibration
from sim.engine.systems.series import BELT_LEDGER, total_since_start
from sim.parameters import BeltParameters
from sim.parameters.belt import LEAST_TRANSPORT
from sim.parameters.variables import recorded_by

#: Skin of the neighbor list in mean diameters.
SKIN = 0.3

#: Intervals of the path over the cycle that ends a run: the paper plots every 50th of 2000 steps.
PATH_INTERVALS = 40

#: Most samples of one call, and most particle-steps between two pauses: some tenths of a second.
MOST_SAMPLES, MOST_WORK = 64, 2_000_000

#: Simulated time (s) after which settling fails if the bed still moves.
SETTLING_LIMIT = 30.0

#: Simulated time (s) between two checks that a fallen bed is at rest.
LOOK_INTERVAL = 0.01

#: Stages before the first sample.
FALLING, PRIOR_SHAKING = "falling", "shaken before"


class Belt:
    """One replicate of beads on the belt in motion."""

    ledger = BELT_LEDGER
    axes = ("x", "z")
    history_profiles = ()
    state_names = ("disks", "pairs", "search", "loop", "normal_loss", "shear_loss", "belt_work")

    def __init__(self, parameters: BeltParameters, replicate: int, substeps: int = 1):
        self.parameters = p = parameters
        self.pause, self.stage = no_pause, FALLING
        self.series = recorded_by(p, "series")
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
            p.normal_damping,
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
        self.loop_time = 0.0
        kind = kind_of(self.law, self.belt, self.integrator)
        self._advance = DirectCall(shaking.advance_disks, kind)
        self._take_samples = DirectCall(bed_samples.sample_bed, kind)
        self._list_contacts = DirectCall(list_bed_contacts, kind)
        self._calls: bed_samples.Calls | None = None
        still = LEAST_TRANSPORT * p.velocity_amplitude
        self.scales = Scales(still, acceleration=np.inf, drift=p.drift, target=p.target)
        self.mass = float(bed.mass.sum())
        self.period = p.samples_per_cycle
        self.slices = bed_profiles(p)
        self.profile_height = self.slices.height()
        self.normal_loss, self.shear_loss, self.belt_work = 0.0, 0.0, 0.0
        self.squares = squares(width, p.diameter, p.amplitude)
        self._room = self._make_room()
        self.coordinates = self.squares.coordinates() | {
            "path_time": (
                "s",
                "time since the path began, at the initial phase of the belt",
                np.linspace(0.0, p.time_unit, PATH_INTERVALS + 1),
            ),
        }

    def _make_room(self) -> bed_samples.BedSamples:
        beads = self.parameters.beads
        self._stretch = max(1, MOST_WORK // beads)
        samples = max(1, min(MOST_SAMPLES, MOST_WORK // (self.sample_steps * beads)))
        return bed_samples.make_samples(samples, beads, self.slices.slices, self.squares)

    def _integrator(self, time_step: float):
        p = self.parameters
        if p.integrator == "verlet":
            return Verlet(float(time_step))
        return Gear(float(time_step), CORRECTORS[p.corrector_order])

    def settle(self) -> None:
        """Let the beads fall onto the resting belt, and shake them at the prior frequency, if any.

        It continues from its ``stage``.
        """
        p, step = self.parameters, self.settling_step
        prior_step = 1.0 / (p.prior_frequency * self.steps_per_cycle) if p.prior_frequency else step
        if self.stage == FALLING:
            self._fall()
            if p.prior_frequency:
                rescale_terms(self.disks.taylor, step, prior_step)
                self.loop, self.stage = shaking.make_shaking(), PRIOR_SHAKING
        if self.stage == PRIOR_SHAKING:
            self._shake_at_prior_frequency(prior_step)
        rescale_terms(self.disks.taylor, prior_step, self.time_step)
        self.disks.taylor[1, 0] += p.initial_velocity * p.velocity_unit * self.time_step
        self.loop, self.stage = shaking.make_shaking(), ""

    def _fall(self) -> None:
        """Let the beads fall onto the resting belt until their mean squared velocity is small."""
        p, step, loop = self.parameters, self.settling_step, self.loop
        belt, integrator = vibration(p, 0.0), self._integrator(step)
        fall, check_interval = (
            max(1, int(time / step)) for time in (self.fall_time, LOOK_INTERVAL)
        )
        mean_square = np.inf
        while mean_square >= p.settle_velocity_squared:
            steps_done = int(loop.step[0])
            if steps_done * step > SETTLING_LIMIT:
                raise BlowUp(
                    f"the bed is not at rest after {SETTLING_LIMIT:g} s: mean mean_square velocity "
                    f"{mean_square:.3g} m2/s2, wanted {p.settle_velocity_squared:g}"
                )
            steps = (
                fall - steps_done
                if steps_done < fall
                else check_interval - (steps_done - fall) % check_interval
            )
            self._run(integrator, belt, steps, "while the bed settles")
            self._stop_free_drift()
            mean_square = float(((self.disks.taylor[1] / step) ** 2).sum(axis=0).mean())

    def take_over(self, other: "Belt") -> None:
        """Continue with the beads of another bed, the belt in its initial phase."""
        if other.loop.step[0] % other.steps_per_cycle:
            raise ValueError("that bed has been shaken for no whole number of cycles")
        self.disks, self.pairs, self.search = other.disks, other.pairs, other.search
        rescale_terms(self.disks.taylor, other.time_step, self.time_step)
        self.stage = ""

    def _shake_at_prior_frequency(self, step: float) -> None:
        """Shake at the prior frequency for whole cycles, in steps of this length."""
        p = self.parameters
        steps = p.prior_cycles * self.steps_per_cycle - int(self.loop.step[0])
        where = "of the shaking at the prior frequency"
        self._run(self._integrator(step), vibration(p, p.prior_frequency), steps, where)

    def _stop_free_drift(self) -> None:
        """Remove the bed's uniform drift where nothing else would: on a belt without friction.

        Damping by each bead's own mass does not conserve momentum, so a settling bed picks up a
        drift along the belt, which only the shear damping of the belt would stop.
        """
        if self.parameters.shear_damping == 0.0:
            self.disks.taylor[1, 0] -= self.disks.taylor[1, 0].mean()

    def _contacts(self, belt) -> shaking.BedContacts:
        return shaking.BedContacts(self.law, self.pairs, belt, self.obstacle, self.search)

    def _motion(self, integrator) -> shaking.BedMotion:
        p = self.parameters
        return shaking.BedMotion(integrator, p.gravity, p.overlap_limit, p.corrections)

    def _run(self, integrator, belt, steps: int, where: str) -> None:
        """Advance by a number of steps without taking a sample, with pauses on the way."""
        loop, motion = self.loop, self._motion(integrator)
        last = loop.step[0] + steps
        while loop.step[0] < last:
            target = min(last, loop.step[0] + self._stretch)
            start_time, status = working_time(), LIST_FULL
            while status == LIST_FULL:
                remaining = target - loop.step[0]
                status = self._advance(self.disks, self._contacts(belt), loop, motion, remaining)
                if status == LIST_FULL:
                    self.pairs = double_room(self.pairs)
            self.loop_time += working_time() - start_time
            if reason := failure_reason(status, self.disks.taylor):
                raise BlowUp(f"{reason} at step {loop.step[0]} {where}")
            if target < last:
                self.pause()

    def _advance_near_sample(self) -> None:
        """Advance until the next sample is no farther away than the next pause."""
        steps_done = self.loop.step[0] % self.sample_steps
        if self.sample_steps - steps_done > self._stretch:
            if steps_done == 0:
                self.loop.sums[:] = 0.0
            steps = self.sample_steps - steps_done - self._stretch
            self._run(self.integrator, self.belt, steps, "of the shaking")
            self.pause()

    def sample(self, most: int = 1, profiles: bool = False) -> Samples:
        """Advance by one to ``most`` samples and return their values and profiles."""
        self._advance_near_sample()
        p, loop, motion = self.parameters, self.loop, self._motion(self.integrator)
        room, count = self._room, min(most, len(self._room.sums))
        room.number[0], room.clock[0] = 0, 0
        amplitude, slice_height = p.amplitude * p.diameter, self.slices.slice_height
        status = LIST_FULL
        while status == LIST_FULL:
            contacts = self._contacts(self.belt)
            if not self._calls:
                self._calls = bed_samples.make_calls(self.disks, contacts, loop, motion)
            sampling = bed_samples.Sampling(
                self._calls,
                count,
                self.sample_steps,
                profiles,
                amplitude,
                slice_height,
                self.squares,
            )
            status = self._take_samples(self.disks, contacts, loop, motion, sampling, room)
            if status == LIST_FULL:
                self.pairs = double_room(self.pairs)
        self.loop_time += 1e-6 * float(room.clock[0])
        samples = Samples(self._values(room), self._profiles(room) if profiles else None)
        if status in REASONS:
            reason = f"{REASONS[status]} at step {loop.step[0]} of the shaking"
            raise BlowUp(reason, samples if room.number[0] else None)
        return samples

    def advance(self) -> dict[str, float]:
        """Advance by one sample and return a value per time series."""
        return self.sample().first()

    def _values(self, room: bed_samples.BedSamples) -> dict[str, np.ndarray]:
        """Return the values (K,) of each time series in the samples taken."""
        p, count = self.parameters, int(room.number[0])
        parts = room.sums, room.stored, room.state
        sums, stored, state = (part[:count].T.copy() for part in parts)
        angle = 2.0 * pi * self._cycle_steps(count) / self.steps_per_cycle + radians(p.phase)
        mean = sums / sums[shaking.STEPS]
        return {
            "mean_velocity": mean[shaking.VELOCITY],
            "mass_flux": mean[shaking.MOMENTUM] / self.box.length[0],
            "kinetic_energy": state[0],
            "potential_energy": p.gravity * np.vecdot(room.mass[:count], room.height[:count]),
            "stored_energy": stored[0] + stored[1] + stored[2],
            "normal_loss": total_since_start(self, "normal_loss", sums[shaking.NORMAL_LOSS]),
            "shear_loss": total_since_start(self, "shear_loss", sums[shaking.SHEAR_LOSS]),
            "belt_work": total_since_start(self, "belt_work", sums[shaking.BELT_WORK]),
            "height_of_mass": state[1],
            "contact_number": mean[shaking.CONTACTS] / p.beads,
            "largest_overlap": sums[shaking.LARGEST],
            "belt_phase": angle % (2.0 * pi),
            "base_occupancy": state[2],
            "wave_power": wave_power(room.waves[:count], p.beads),
            "belt_normal_force": mean[shaking.BELT_PUSH_Z],
            "belt_shear_force": -mean[shaking.BELT_PUSH_X],
            "belt_contacts": mean[shaking.BELT_CONTACTS],
            "belt_contact_time": mean[shaking.BELT_TOUCH_STEPS],
        }

    def _cycle_steps(self, count: int) -> np.ndarray:
        """Return the steps since the belt was last in its initial phase, at the last samples."""
        number = self.loop.step[0] // self.sample_steps - np.arange(count)[::-1]
        return number * self.sample_steps % self.steps_per_cycle

    def _profiles(self, room: bed_samples.BedSamples) -> Sums:
        """Return profiles and field of the samples taken, and the sums requested by phase."""
        centres, area, field = room.profiles()
        phase = self._phases(int(room.number[0]))
        return centres, area, field, *self.slices.phase_sums(centres, area, phase)

    def _phases(self, count: int) -> np.ndarray:
        """Return the numbers of the last samples in their cycle; 0 is nearest to its beginning."""
        p = self.parameters
        turns = self._cycle_steps(count) / self.steps_per_cycle + p.phase / 360.0
        return np.round(turns * p.samples_per_cycle).astype(int) % p.samples_per_cycle

    def _velocity(self) -> np.ndarray:
        return self.disks.taylor[1] / self.time_step

    def current_contacts(self, most: int) -> ContactList:
        """Return the contacts of the present state, listed if there are at most ``most``."""
        contacts, time = no_contacts(most, axes=2), float(self.loop.step[0] * self.time_step)
        self._list_contacts(contacts, self.disks, self._contacts(self.belt), time, self.time_step)
        return contacts

    def no_profiles(self) -> Sums:
        """Return sums of zero: profiles by centres and by area, the field, sums by phase."""
        centres, area, *phased = self.slices.empty()
        return centres, area, self.squares.empty(), *phased

    def profiles(self, sums: Sums) -> dict[str, np.ndarray]:
        """Return velocity, densities and granular temperature per slice."""
        return self.slices.profiles(*sums[:2])

    def tables(self, sums: Sums) -> dict[str, np.ndarray]:
        """Return means in squares of the laboratory, and the tables requested by phase."""
        centres, _, field, *phased = sums
        return self.squares.tables(field) | self.slices.tables(centres, phased)

    def trace(self) -> np.ndarray:
        """Finish the cycle and return the path of every bead (S, N, 2) in m over one more."""
        steps = self.steps_per_cycle
        self._run(self.integrator, self.belt, -self.loop.step[0] % steps, "of the last cycle")
        states = [self._initial_order(self.disks.taylor[0])]
        for k in range(PATH_INTERVALS):
            interval = (k + 1) * steps // PATH_INTERVALS - k * steps // PATH_INTERVALS
            self._run(self.integrator, self.belt, interval, "of the path")
            states.append(self._initial_order(self.disks.taylor[0]))
            moved = states[-1][:, 0] - states[-2][:, 0]
            states[-1][:, 0] -= self.box.length[0] * np.round(moved / self.box.length[0])
        return np.array(states)

    def _initial_order(self, vectors: np.ndarray) -> np.ndarray:
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
