"""Parameters of the vibrating belt; defaults are those of Gallas, Herrmann, Sokołowski (1992)."""

import math
from typing import Any, ClassVar, Literal

from sim.parameters import roles
from sim.parameters.common import MAX_PARTICLES, MAX_STEPS, Parameters, Real, broken_rule
from sim.parameters.roles import declare, numerics, reading

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
    smallest_values: ClassVar[dict[str, Any]] = {"beads": 2, "settle_velocity_squared": 1e6}
    fixed_parameters: ClassVar[tuple[str, ...]] = (
        *("seed", "beads", "width", "diameter", "diameter_spread", "mass", "obstacle", "phase"),
        *("belt_ghost", "integrator", "corrector_order"),
    )

    system: Literal["belt"] = declare("belt", description="which of the systems")
    frequency: Real = roles.frequency(equation="Gallas, Eqs. 1a, 1b")
    amplitude: Real = declare(
        1,
        symbol="A_z",
        scale="⟨d⟩",
        description="vertical amplitude of the vibration",
        equation="Gallas, Eq. 1b",
        id_part="amplitude",
        ge=0,
    )
    vibration_angle: Real = declare(
        45,
        symbol="α",
        unit="degree",
        description="angle of the vibration with the horizontal (90: vertical)",
        equation="Gallas, Sec. 2: α = arctan(A_z/A_x)",
        id_part="angle",
        gt=0,
        le=90,
    )
    damping: Real = declare(
        50,
        symbol="γ",
        scale="g",
        description="normal damping coefficient",
        equation="Gallas, Eq. 3",
        id_part="damping",
        ge=0,
    )
    shear_damping: Real = roles.shear_damping(
        description="shear friction coefficient", id_part="shear"
    )
    stiffness: Real = declare(
        STIFFNESS,
        symbol="Y",
        scale="g⟨m⟩/⟨d⟩",
        description="stiffness of the elastic restoration force",
        equation="Gallas, Eq. 2",
        gt=0,
    )
    beads: int = declare(
        200,
        symbol="N",
        description="number of beads",
        equation="Gallas, Sec. 2",
        ge=1,
        le=MAX_PARTICLES,
    )
    width: Real = declare(
        20,
        symbol="L",
        scale="⟨d⟩",
        description="length of the periodic segment of the belt",
        equation="Gallas, Sec. 2",
        ge=5,
    )
    obstacle: Real = declare(
        0,
        symbol="d_o",
        scale="⟨d⟩",
        description="diameter of the fixed obstacle, below width - 3 (0: none)",
        equation="Gallas, Sec. 3, Fig. 6",
        ge=0,
    )
    initial_velocity: Real = roles.initial_velocity(
        0,
        scale="√(g⟨d⟩)",
        description="velocity along the belt of all beads when the shaking starts",
        equation="Gallas, Sec. 3, Fig. 3c: dashed line",
    )
    prior_frequency: Real = declare(
        0,
        symbol="f0",
        unit="Hz",
        description="frequency at which the bed has been shaken before, for sweeps (0: at rest)",
        ge=0,
    )
    prior_cycles: int = numerics(
        60,
        symbol="t_0",
        scale="cycles",
        description="how many cycles of prior_frequency went before",
        ge=1,
        le=100_000,
    )
    diameter: Real = declare(
        1e-3,
        symbol="⟨d⟩",
        unit="m",
        description="mean diameter of the beads",
        equation="Gallas, Sec. 2",
        gt=0,
    )
    diameter_spread: Real = declare(
        0.5,
        symbol="Δd/⟨d⟩",
        scale="⟨d⟩",
        description="half width of the uniform distribution of diameters",
        equation="Gallas, Sec. 2",
        ge=0,
        lt=1,
    )
    mass: Real = declare(
        1e-6,
        symbol="⟨m⟩",
        unit="kg",
        description="mass of a bead of mean diameter (drops out of the motion)",
        equation="Gallas, Sec. 3",
        gt=0,
    )
    gravity: Real = roles.gravity(10, equation="Gallas, Sec. 2")
    phase: Real = declare(
        0,
        symbol="φ0",
        unit="degree",
        description="phase of the belt when the shaking starts",
        ge=0,
        lt=360,
    )
    steps_per_cycle: int = numerics(
        2000,
        symbol="1/(fΔt)",
        description="time steps in one cycle of the vibration",
        equation="Gallas, Sec. 2: Δt = 1/(2000 f)",
        ge=100,
        le=1_000_000,
    )
    samples_per_cycle: int = roles.samples_per_cycle(
        description="samples of the observables in one cycle (divides steps_per_cycle)"
    )
    slice_height: Real = numerics(
        1,
        symbol="Δz",
        scale="⟨d⟩",
        description="height of the slices of the profiles (0.5 gives every grid of ⟨d⟩)",
        equation="Gallas, Sec. 3",
        added=True,
        ge=0.1,
        le=10,
    )
    phase_0_profiles: bool = roles.extra(
        description="also average the profiles at the beginning of the cycle alone, when the "
        "belt is at its mean height and rises",
        equation="Gallas, Sec. 3, Fig. 5",
    )
    fluctuation_profiles: bool = roles.extra(
        description="also keep the granular temperature about the mean velocity at each phase of "
        "the cycle, of which there are samples_per_cycle"
    )
    belt_forces: bool = roles.extra(
        description="also keep the forces on the belt and when it is touched, as time series"
    )
    trajectory: Real = roles.trajectory(scale=roles.CYCLES)
    transient: Real = roles.transient(
        45,
        scale=roles.CYCLES,
        description="length discarded before averaging",
        equation="Gallas, Sec. 2: 9·10⁴ steps",
    )
    average: Real = roles.average(
        45,
        scale=roles.CYCLES,
        description="length averaged over",
        equation="Gallas, Sec. 2: 9·10⁴ steps",
    )
    limit: Real = roles.limit(1500, scale=roles.CYCLES)
    settle_velocity_squared: Real = numerics(
        1e-8,
        symbol="⟨v²⟩",
        unit="m2 s-2",
        description="mean squared velocity below which the bed is at rest and the shaking starts",
        equation="Gallas, Sec. 2",
        gt=0,
    )
    overlap_limit: Real = numerics(
        0.95,
        symbol="δ_lim",
        scale="r_i + r_j",
        description="overlap at which the run stops as unphysical (the published stiffness lets "
        "beads overlap by more than half a radius from 20 Hz on)",
        gt=0,
        le=0.95,
    )
    damping_mass: Literal["own", "reduced"] = reading(
        "own",
        description="mass in the damping terms: the bead's own, or the reduced mass of the pair",
        equation="Gallas, Eqs. 3, 4",
        compiled=True,
    )
    belt_ghost: Literal["below", "centred"] = reading(
        "below",
        description="the belt acts as a bead that is tangent to its line from below, or centred "
        "on it",
        equation="Gallas, Sec. 2",
    )
    ghost_mass: Literal["infinite", "mean"] = reading(
        "infinite",
        description="mass of the bead as which the belt acts: infinite, or that of a bead of mean "
        "diameter (with damping_mass: reduced)",
        equation="Gallas, Sec. 2",
        added=True,
    )
    attraction: Literal["kept", "clipped"] = reading(
        "kept",
        description="an attractive total normal force at the end of a contact is kept or set to 0",
        equation="Gallas, Eqs. 2, 3",
        compiled=True,
    )
    integrator: Literal["gear", "verlet"] = reading(
        "gear",
        description="Gear predictor-corrector, or velocity Verlet",
        equation="Gallas, Sec. 2",
        compiled=True,
    )
    corrector_order: int = reading(
        5,
        description="order of Gear's predictor-corrector: 3, 4 or 5, which keep as many "
        "derivatives of the position",
        equation="Gallas, Sec. 2",
        added=True,
        ge=3,
        le=5,
    )
    corrections: int = reading(
        1,
        description="how often Gear's corrector acts in a step, with forces evaluated anew",
        equation="Gallas, Sec. 2",
        added=True,
        ge=1,
        le=2,
    )
    stiffness_keeps: Literal["damping", "restitution"] = reading(
        "damping",
        description="another stiffness than the paper's leaves γ as it is, or multiplies it by "
        "√(Y/1000), which leaves the restitution",
        equation="Gallas, Sec. 3",
        added=True,
    )

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
        """Raise for values that do not go together."""
        super().require_rules()
        if self.obstacle > 0 and not self.obstacle < self.width - 3:
            allowed = f"a number in [0, width - 3) = [0, {self.width - 3:g})"
            raise broken_rule("obstacle", self.obstacle, allowed)
        if self.steps_per_cycle % self.samples_per_cycle:
            allowed = f"a divisor of steps_per_cycle = {self.steps_per_cycle}"
            raise broken_rule("samples_per_cycle", self.samples_per_cycle, allowed)
        if SETTLING_TIME / self.settling_step > MAX_STEPS:
            if self.settling_step == self._collision / 20:
                key = "stiffness"
            else:
                strong = self.damping * self._softening > self.shear_damping
                key = "damping" if strong else "shear_damping"
            allowed = f"a value that lets the run begin after at most {MAX_STEPS:.0e} time steps"
            raise broken_rule(key, getattr(self, key), allowed)
        if self.ghost_mass == "mean" and self.damping_mass == "own":
            allowed = "'infinite' with damping_mass: own, where no partner's mass counts"
            raise broken_rule("ghost_mass", self.ghost_mass, allowed)
        for name, only in (("corrector_order", 5), ("corrections", 1)):
            if self.integrator == "verlet" and getattr(self, name) != only:
                allowed = f"{only} with integrator: verlet, which has no corrector"
                raise broken_rule(name, getattr(self, name), allowed)
