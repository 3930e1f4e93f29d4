"""The vibrating belt of Gallas, Herrmann and Sokolowski: beads on a line that shakes."""

from math import pi, radians, sqrt
from typing import Any

import numpy as np

from sim.engine.boundary.belt import Obstacle
from sim.engine.compile import address_of, call_directly, kind_of
from sim.engine.contact.damping import spring_damping
from sim.engine.dynamics.cells import LIST_FULL, BlowUp, make_box
from sim.engine.dynamics.disks import make_disks, rescale_terms
from sim.engine.dynamics.neighbors import empty_pair_list, make_search
from sim.engine.observe.profiles import wave_power
from sim.engine.observe.regime import Scales
from sim.engine.observe.samples import ContactList, Samples, Sums, first_samples, make_ledger
from sim.engine.systems import bed_samples, shaking
from sim.engine.systems.bed_samples import list_bed_contacts
from sim.engine.systems.replica import PATH_INTERVALS, Replica
from sim.engine.systems.slices import bed_profiles
from sim.engine.systems.start import (
    FALLING,
    PRIOR_SHAKING,
    SHAKING,
    initial_bed,
    make_stages,
    settle_once,
)
from sim.parameters import BeltParameters
from sim.parameters.belt import LEAST_TRANSPORT

#: Skin of the neighbor list in mean diameters.
SKIN = 0.3

#: Most samples of one call.
MOST_SAMPLES = 64

#: Simulated time (s) after which settling fails if the bed still moves.
SETTLING_LIMIT = 30.0

#: Simulated time (s) between two checks that a fallen bed is at rest.
LOOK_INTERVAL = 0.01


class Belt(Replica):
    """One replicate of beads on the belt in motion."""

    parameters: BeltParameters
    ledger = make_ledger(
        *("kinetic_energy", "potential_energy", "stored_energy"),
        *("normal_loss", "shear_loss", "belt_work"),
        turnover=("belt_work",),
    )
    axes = ("x", "z")
    particle_names = ("disks", "pairs", "search")
    state_names = (*particle_names, "loop", "normal_loss", "shear_loss", "belt_work")

    def __init__(self, parameters: BeltParameters, replicate: int, substeps: int = 1):
        super().__init__(parameters, substeps)
        p, width = parameters, parameters.width * parameters.diameter
        self.period = p.samples_per_cycle
        self.path_steps = self.cycle_steps
        settling_step = p.settling_step / substeps
        after_fall = PRIOR_SHAKING if p.prior_frequency else SHAKING
        self.stage = after_fall if p.initial_state else FALLING
        self._stages = make_stages(p, settling_step, self.time_step, self.cycle_steps)
        self.box = make_box(width)
        bed = initial_bed(p, self.box, replicate)
        self._fall_time = sqrt(2.0 * (bed.height + p.diameter) / p.gravity)
        self.disks = make_disks(
            bed.position, bed.velocity, bed.radius, bed.mass, self._step_length()
        )
        if p.initial_state:
            # So that a free fall is exact from its first step on.
            self.disks.taylor[2, 1] = -0.5 * p.gravity * self._step_length() ** 2
        self.mass = float(bed.mass.sum())
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
        self.loop = shaking.make_shaking()
        self.normal_loss, self.shear_loss, self.belt_work = 0.0, 0.0, 0.0
        self.kind = kind_of(self.law, self._stages[SHAKING].belt, self._stages[SHAKING].integrator)
        self._calls: bed_samples.Calls | None = None
        still = LEAST_TRANSPORT * p.velocity_amplitude
        self.scales = Scales(still, np.inf, p.drift, p.target)
        self.slices = bed_profiles(p)
        most = max(1, min(MOST_SAMPLES, self._stretch // self.sample_steps))
        self._room = bed_samples.make_samples(
            most, p.beads, self.slices.slices, self.slices.squares
        )
        self.coordinates = self.slices.squares.coordinates() | {
            "path_time": (
                "s",
                "time since the path began, at the initial phase of the belt",
                np.linspace(0.0, p.time_unit, PATH_INTERVALS + 1),
            ),
        }

    def _step_length(self) -> float:
        """Return the time step of the present stage, s."""
        return self._stages[self.stage].integrator.time_step

    def settle(self) -> None:
        """Let the beads fall onto the resting belt, and shake them at the prior frequency, if any.

        It continues from its ``stage``. Given beads do not fall first.
        """
        p = self.parameters
        if self.stage == FALLING:
            self._fall()
            self._enter(PRIOR_SHAKING if p.prior_frequency else SHAKING)
        if self.stage == PRIOR_SHAKING:
            self._run(p.prior_cycles * self.cycle_steps - int(self.loop.step[0]))
            self._enter(SHAKING)
        self.disks.taylor[1, 0] += p.initial_velocity * p.velocity_unit * self.time_step

    def _enter(self, stage: str) -> None:
        """Begin a stage with the beads as they are, the belt in its initial phase."""
        step, self.stage = self._step_length(), stage
        rescale_terms(self.disks.taylor, step, self._step_length())
        self.loop = shaking.make_shaking()

    def _fall(self) -> None:
        """Let the beads fall onto the resting belt, as an equal bed has before, if there is one."""
        p, step = self.parameters, self._step_length()
        fall, check_interval = (
            max(1, int(time / step)) for time in (self._fall_time, LOOK_INTERVAL)
        )
        # All that `_rest` reads: its arguments, and the motion of the stage.
        looks = fall, check_interval, p.settle_velocity_squared, p.shear_damping == 0.0
        given = self.disks, self._contacts(), self.loop, self._motion(), *looks

        def settle() -> tuple[Any, ...]:
            self._rest(*looks)
            return self.disks, self.pairs, self.search

        self.disks, self.pairs, self.search = settle_once(self.kind, given, settle)

    def _rest(self, fall: int, interval: int, square: float, is_free: bool) -> None:
        """Advance by the steps of the fall, then from look to look until the bed is at rest.

        Its mean squared velocity is then below ``square`` (m²/s²). Where ``is_free`` of friction
        with the belt, its uniform drift is removed: damping by each bead's own mass does not
        conserve momentum, so a bed picks one up that only shear damping would stop.
        """
        step, loop = self._step_length(), self.loop
        mean_square = np.inf
        while mean_square >= square:
            steps_done = int(loop.step[0])
            if steps_done * step > SETTLING_LIMIT:
                raise BlowUp(
                    f"the bed is not at rest after {SETTLING_LIMIT:g} s: mean squared velocity "
                    f"{mean_square:.3g} m2/s2, wanted {square:g}"
                )
            self._run(
                fall - steps_done
                if steps_done < fall
                else interval - (steps_done - fall) % interval
            )
            if is_free:
                self.disks.taylor[1, 0] -= self.disks.taylor[1, 0].mean()
            mean_square = float(((self.disks.taylor[1] / step) ** 2).sum(axis=0).mean())

    def take_over(self, other: "Belt") -> None:
        """Continue with the beads of another bed, the belt in its initial phase."""
        other.require_whole_cycles()
        super().take_over(other)
        rescale_terms(self.disks.taylor, other.time_step, self.time_step)

    def trace(self) -> np.ndarray:
        """Finish the cycle and return the path of every bead (S, N, 2) in m over one more."""
        self._run(-self.loop.step[0] % self.cycle_steps)
        return super().trace()

    def _contacts(self) -> shaking.BedContacts:
        belt = self._stages[self.stage].belt
        return shaking.BedContacts(self.law, self.pairs, belt, self.obstacle, self.search)

    def _motion(self) -> shaking.BedMotion:
        p, integrator = self.parameters, self._stages[self.stage].integrator
        refresh = address_of(shaking.refresh_beads, "", self.disks, self.pairs)
        return shaking.BedMotion(integrator, p.gravity, p.overlap_limit, p.corrections, refresh)

    def _advance(self, steps: int) -> int:
        contacts, motion = self._contacts(), self._motion()
        kernel = shaking.advance_disks
        return call_directly(kernel, self.kind, self.disks, contacts, self.loop, motion, steps)

    def _take(self, most: int, profiles: bool) -> tuple[Samples | None, str]:
        # A bed that has not settled is sampled as it shakes, too.
        self.stage = SHAKING
        if self.sample_steps > self._stretch:
            self._continue(self._missing_steps() - self._stretch)
            self.pause()
        room = self._room
        room.number[0], room.clock[0] = 0, 0
        while (status := self._fill(min(most, len(room.sums)), profiles)) == LIST_FULL:
            self.make_room()
        self.loop_time += 1e-6 * float(room.clock[0])
        failure = self._failure(status)
        if not room.number[0]:
            return None, failure
        return Samples(self._values(room), self._profiles(room) if profiles else None), failure

    def _fill(self, samples: int, profiles: bool) -> int:
        """Take so many samples in compiled code, those taken so far included; return the status."""
        p, disks, loop = self.parameters, self.disks, self.loop
        contacts, motion = self._contacts(), self._motion()
        if not self._calls:
            self._calls = bed_samples.make_calls(disks, contacts, loop, motion)
        sampling = bed_samples.Sampling(
            self._calls,
            samples,
            self.sample_steps,
            profiles,
            p.amplitude * p.diameter,
            self.slices.slice_height,
            self.slices.squares,
        )
        kernel = bed_samples.sample_bed
        return call_directly(kernel, self.kind, disks, contacts, loop, motion, sampling, self._room)

    def _values(self, state: bed_samples.BedSamples) -> dict[str, np.ndarray]:
        """Return the values (K,) of each time series in the samples taken."""
        p, count = self.parameters, int(state.number[0])
        # The next samples overwrite these arrays.
        sums, springs, moment = (
            part[:count].T.copy() for part in (state.sums, state.stored, state.state)
        )
        kinetic, height, near = moment
        angle = 2.0 * pi * self._steps_in_cycle(count) / self.cycle_steps + radians(p.phase)
        mean = sums / sums[shaking.STEPS]
        return {
            "mean_velocity": mean[shaking.VELOCITY],
            "mass_flux": mean[shaking.MOMENTUM] / self.box.length[0],
            "kinetic_energy": kinetic,
            "potential_energy": p.gravity * np.vecdot(state.mass[:count], state.height[:count]),
            "stored_energy": springs[0] + springs[1] + springs[2],
            "normal_loss": self._total("normal_loss", sums[shaking.NORMAL_LOSS]),
            "shear_loss": self._total("shear_loss", sums[shaking.SHEAR_LOSS]),
            "belt_work": self._total("belt_work", sums[shaking.BELT_WORK]),
            "height_of_mass": height,
            "contact_number": mean[shaking.CONTACTS] / p.beads,
            "largest_overlap": sums[shaking.LARGEST],
            "belt_phase": angle % (2.0 * pi),
            "base_occupancy": near,
            "wave_power": wave_power(state.waves[:count], p.beads),
            "belt_normal_force": mean[shaking.BELT_PUSH_Z],
            "belt_shear_force": -mean[shaking.BELT_PUSH_X],
            "belt_contacts": mean[shaking.BELT_CONTACTS],
            "belt_contact_time": mean[shaking.BELT_TOUCH_STEPS],
        }

    def _steps_in_cycle(self, count: int) -> np.ndarray:
        """Return the steps since the belt was last in its initial phase, at the last samples."""
        number = self.loop.step[0] // self.sample_steps - np.arange(count)[::-1]
        return number * self.sample_steps % self.cycle_steps

    def _profiles(self, room: bed_samples.BedSamples) -> Sums:
        """Return profiles and field of the samples taken, and the sums requested by phase."""
        p, count = self.parameters, int(room.number[0])
        sums: Any = first_samples((room.centres, room.area, room.field), count)
        cycles = self._steps_in_cycle(count) / self.cycle_steps + p.phase / 360.0
        phase = np.round(cycles * self.period).astype(int) % self.period
        return *sums, *self.slices.phase_sums(*sums[:2], phase)

    def _velocity(self) -> np.ndarray:
        return self.disks.taylor[1] / self.time_step

    def _arrays(self) -> dict[str, np.ndarray]:
        return {
            "label": self.disks.label[0],
            "position": self.disks.taylor[0],
            "particle_velocity": self._velocity(),
            "radius": self.disks.radius,
        }

    def _list_contacts(self, contacts: ContactList) -> None:
        time = float(self.loop.step[0] * self.time_step)
        bed = self._contacts()
        arguments = contacts, self.disks, bed, time, self.time_step
        call_directly(list_bed_contacts, self.kind, *arguments)

    def _coordinates(self) -> np.ndarray:
        return self.disks.taylor

    def _moment(self) -> str:
        return self._stages[self.stage].words
