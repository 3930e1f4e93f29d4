"""Parameters of the vibrating belt; defaults are those of Gallas, Herrmann, Sokołowski (1992)."""

import math
from typing import Any, ClassVar, Literal

from sim.parameters.common import MAX_PARTICLES, MAX_STEPS, Parameters, Real, in_place
from sim.parameters.roles import rows_of

row = rows_of("belt")

#: Stiffness (g⟨m⟩/⟨d⟩) of the paper.
STIFFNESS = 1000.0

#: Stability of Gear's corrector by its order and number of corrections: s and k of the largest
#: damping rate times time step, λΔt = s (1 - k (ωΔt)²), at which it damps an oscillator of
#: frequency ω (python -m benchmarks.stability; within 2 % for ωΔt up to 0.7).
GEAR_STABILITY = {
    (3, 1): (0.545, 0.5),
    (4, 1): (0.3, 0.92),
    (5, 1): (0.163, 1.57),
    (3, 2): (1.729, 0.335),
    (4, 2): (1.285, 0.375),
    (5, 2): (0.947, 0.41),
}

#: Largest damping rate of a packed bed, in multiples of the larger and the smaller of γ and γ_s, by
#: the mass in the damping terms, whatever the mass of the belt's ghost; its largest frequency in
#: √(Yg/⟨d⟩); and the share of rate and frequency that counts, as the most damped motion is not the
#: stiffest one.
DAMPING_RATES = {"own": (5.6, 2.9), "reduced": (2.6, 1.2)}
FREQUENCY = 3.4
COUNTED_SHARE = 0.95

#: Upper bound of the settling's time step times 4.5 (γ + γ_s): within any corrector's stability.
SETTLING_DAMPING = 2 / 3 * 0.15

#: Shares of the belt's velocity amplitude: below the first a bed counts as arrested, above the
#: second as transported (in searches for boundaries). Between the two it creeps.
LEAST_TRANSPORT = 0.02
ONSET_TRANSPORT = 0.1

#: Particle-steps per second on one core of a present-day server, and seconds of simulated time
#: until a released bed is at rest.
RATE = 55.0e6
SETTLING_TIME = 0.7

#: Time until a bed of little damping is at rest, over 1/(γ + γ_s). That of one damped by the beads'
#: own masses, over 1/γ_s: it picks up a drift that shear damping alone stops. And the longest, s.
DAMPED_TIME, DRIFT_TIME, LONGEST_SETTLING = 50.0, 25.0, 30.0


class BeltParameters(Parameters):
    """Disks on a belt that vibrates at an angle (Gallas, Herrmann and Sokołowski 1992).

    Lengths in mean diameters ⟨d⟩, damping in multiples of g (50 means 500 s⁻¹ at g = 10 m s⁻²)
    and lengths of the run in cycles where the description says so; everything else is SI.
    Properties return SI.
    """

    sampling_key: ClassVar[str] = "samples_per_cycle"
    state_numbers: ClassVar[int] = 4
    axes: ClassVar[int] = 2
    # A contact counts for each of its two partners; those with belt and obstacle are included.
    most_contacts: ClassVar[int] = 10
    boundaries: ClassVar[tuple[str, ...]] = ("flow", "transport")
    in_place: ClassVar[dict[str, Any]] = Parameters.in_place | {"stroke": in_place("stroke")}
    smallest_values: ClassVar[dict[str, Any]] = {"beads": 2, "settle_velocity_squared": 1e6}
    system: Literal["belt"] = row("system")
    frequency: Real = row("frequency")
    amplitude: Real = row("amplitude")
    vibration_angle: Real = row("vibration_angle")
    damping: Real = row("damping")
    shear_damping: Real = row("shear_damping")
    stiffness: Real = row("stiffness", default=STIFFNESS)
    beads: int = row("beads", le=MAX_PARTICLES)
    width: Real = row("width")
    obstacle: Real = row("obstacle")
    initial_velocity: Real = row("initial_velocity")
    prior_frequency: Real = row("prior_frequency")
    prior_cycles: int = row("prior_cycles")
    diameter: Real = row("diameter")
    diameter_spread: Real = row("diameter_spread")
    mass: Real = row("mass")
    gravity: Real = row("gravity")
    phase: Real = row("phase")
    steps_per_cycle: int = row("steps_per_cycle")
    samples_per_cycle: int = row("samples_per_cycle")
    slice_height: Real = row("slice_height")
    phase_0_profiles: bool = row("phase_0_profiles")
    fluctuation_profiles: bool = row("fluctuation_profiles")
    belt_forces: bool = row("belt_forces")
    trajectory: Real = row("trajectory")
    transient: Real = row("transient")
    average: Real = row("average")
    limit: Real = row("limit")
    settle_velocity_squared: Real = row("settle_velocity_squared")
    overlap_limit: Real = row("overlap_limit")
    damping_mass: Literal["own", "reduced"] = row("damping_mass")
    belt_ghost: Literal["below", "centred"] = row("belt_ghost")
    ghost_mass: Literal["infinite", "mean"] = row("ghost_mass")
    attraction: Literal["kept", "clipped"] = row("attraction")
    integrator: Literal["gear", "verlet"] = row("integrator")
    corrector_order: int = row("corrector_order")
    corrections: int = row("corrections")
    stiffness_keeps: Literal["damping", "restitution"] = row("stiffness_keeps")

    @property
    def ground(self) -> float:
        """Height of the belt's surface in its initial phase, m."""
        surface = 0.5 if self.belt_ghost == "centred" else 0.0
        return (self.amplitude * math.sin(math.radians(self.phase)) + surface) * self.diameter

    @property
    def time_unit(self) -> float:
        """Period of the vibration, s."""
        return 1 / self.frequency

    @property
    def time_step(self) -> float:
        """Time step, s."""
        return self.time_unit / self.steps_per_cycle

    @property
    def normal_damping(self) -> float:
        """Normal damping coefficient γ, 1/s, at the given stiffness."""
        return self.damping * self.gravity * self._softening

    @property
    def _softening(self) -> float:
        """Factor of γ at another stiffness than the paper's: 1 or √(Y/1000), by stiffness_keeps."""
        keeps = self.stiffness_keeps == "damping"
        return 1.0 if keeps else math.sqrt(self.stiffness / STIFFNESS)

    @property
    def velocity_amplitude(self) -> float:
        """Unit of transport velocities, m/s: the belt's velocity amplitude along x, A_x 2πf.

        For a vertical vibration it is A_z 2πf; amplitudes below 0.01 ⟨d⟩ count as 0.01 ⟨d⟩.
        """
        along = self.vibration_angle < 90
        slope = math.tan(math.radians(self.vibration_angle)) if along else 1.0
        amplitude = max(self.amplitude / slope or self.amplitude, 0.01) * self.diameter
        return amplitude * 2 * math.pi * self.frequency

    @property
    def throw_number(self) -> float:
        """Largest vertical acceleration of the belt over gravity, A_z ω²/g."""
        rate = 2 * math.pi * self.frequency
        return rate * rate * self.amplitude * self.diameter / self.gravity

    @property
    def settling_step(self) -> float:
        """Time step while the bed settles, s.

        A twentieth of a collision of the lightest pair, and at most the stability limit of any
        corrector in a packed bed.
        """
        rate = 4.5 * (self.damping * self._softening + self.shear_damping) * self.gravity
        return min(self._collision / 20, SETTLING_DAMPING / rate if rate else math.inf)

    @property
    def _collision(self) -> float:
        """Duration of a collision of the lightest pair, s."""
        reduced_mass = (1 - self.diameter_spread) ** 2 / 2
        return math.pi * math.sqrt(reduced_mass * self.diameter / (self.stiffness * self.gravity))

    @property
    def damping_rate(self) -> float:
        """Largest damping rate of a packed bed, 1/s: about that of settled beds."""
        larger, smaller = DAMPING_RATES[self.damping_mass]
        rates = self.normal_damping, self.shear_damping * self.gravity
        return larger * max(rates) + smaller * min(rates)

    @property
    def bed_frequency(self) -> float:
        """Largest frequency ω of a packed bed, 1/s: about that of settled beds."""
        return FREQUENCY * math.sqrt(self.stiffness * self.gravity / self.diameter)

    @property
    def is_stable(self) -> bool:
        """True where the time step is within the integrator's stability in a packed bed."""
        step = COUNTED_SHARE * self.time_step
        limit, bend = GEAR_STABILITY[self.corrector_order, self.corrections]
        stable_rate = limit * (1 - bend * (self.bed_frequency * step) ** 2)
        return self.integrator != "gear" or self.damping_rate * step <= stable_rate

    @property
    def caveat(self) -> str:
        """Warning of a time step beyond Gear's stability in a packed bed, or an empty text."""
        if self.is_stable:
            return ""
        return (
            "the time step is beyond the stability of Gear's corrector in a packed bed, which may "
            "jitter; more steps_per_cycle or velocity Verlet cures it"
        )

    @property
    def sample_steps(self) -> int:
        """Time steps between two samples."""
        return max(1, self.steps_per_cycle // self.samples_per_cycle)

    @property
    def period(self) -> float:
        """Length of the periodic segment along x, m."""
        return self.width * self.diameter

    @property
    def particles(self) -> int:
        """Number of beads."""
        return self.beads

    @property
    def rate(self) -> float:
        """Particle-steps per second, about."""
        return RATE / self.corrections

    @property
    def settling_steps(self) -> int:
        """Time steps before the first sample, about: the bed's settling and the prior cycles."""
        prior = self.prior_cycles * self.steps_per_cycle if self.prior_frequency > 0.0 else 0
        drifts = self.damping_mass == "own" and self.shear_damping > 0.0
        drift = DRIFT_TIME / (self.shear_damping * self.gravity) if drifts else 0.0
        rate = (self.damping + self.shear_damping) * self.gravity
        damped = DAMPED_TIME / rate if rate else math.inf
        time = max(SETTLING_TIME, min(max(drift, damped), LONGEST_SETTLING))
        return round(time / self.settling_step) + prior

    def require_rules(self) -> None:
        super().require_rules()
        if self.initial_state:
            self.require_default("diameter_spread", "there is no initial_state")
        allowed = f"a number in [0, width - 3) = [0, {self.width - 3:g})"
        self.require("obstacle", self.obstacle == 0 or self.obstacle < self.width - 3, allowed)
        allowed = f"a divisor of steps_per_cycle = {self.steps_per_cycle}"
        divides = self.steps_per_cycle % self.samples_per_cycle == 0
        self.require("samples_per_cycle", divides, allowed)
        strong = self.damping * self._softening > self.shear_damping
        key = "damping" if strong else "shear_damping"
        if self.settling_step == self._collision / 20:
            key = "stiffness"
        allowed = f"a value that lets the run begin after at most {MAX_STEPS:.0e} time steps"
        self.require(key, SETTLING_TIME / self.settling_step <= MAX_STEPS, allowed)
        allowed = "'infinite' with damping_mass: own, where no partner's mass counts"
        counts = self.damping_mass != "own"
        self.require("ghost_mass", counts or self.ghost_mass == "infinite", allowed)
        for name, only in (("corrector_order", 5), ("corrections", 1)):
            is_usual = self.integrator != "verlet" or getattr(self, name) == only
            self.require(name, is_usual, f"{only} with integrator: verlet, which has no corrector")
