"""Parameters of the inclined chute; defaults are those of Walton (1993)."""

import math
from typing import Any, ClassVar, Literal, Self

from pydantic import model_validator

from sim.parameters.common import (
    MAX_PARTICLES,
    Parameters,
    Real,
    broken_rule,
    require_feasible_trajectory,
)
from sim.parameters.roles import declare

#: Particle-steps per second on one core of a present-day server up to a depth, and the power by
#: which the rate falls with depth above it: there are more contacts per particle.
RATE = 45.0e6
RATE_DEPTH = 5.0
RATE_EXPONENT = -0.55

#: Largest overlap of an impact in diameters for which the laws of small overlaps stand: twice that
#: of the paper's softest spheres.
SMALL = 0.1

_TOO_SOFT = (
    f"overlap by more than {100 * SMALL:g} % of a diameter, beyond the range of the contact law; a "
    "larger stiffness cures it"
)


def negligible_acceleration(gravity: float, angle: float) -> float:
    """Return the acceleration (m s⁻²) that is none at an angle (degree): 1 % of g sin θ.

    The sine counts as 0.1 at least.
    """
    return 0.01 * gravity * max(math.sin(math.radians(angle)), 0.1)


class ChuteParameters(Parameters):
    """Spheres flowing down an inclined frictional plane (Walton 1993).

    Lengths in diameters, times in √(σ/g) and velocities in √(gσ) where the description says so;
    everything else is SI. Properties return SI.
    """

    sampling_key: ClassVar[str] = "sample_interval"
    state_numbers: ClassVar[int] = 9
    boundaries: ClassVar[tuple[str, ...]] = ("flow", "acceleration")
    smallest: ClassVar[dict[str, Any]] = {"depth": 0.2, "cell": 5}
    kept: ClassVar[tuple[str, ...]] = (
        *("seed", "depth", "cell", "diameter", "diameter_spread", "mass", "bumps", "bump_coverage"),
        *("restitution", "stiffness", "law", "tangential_ratio", "tangential_exponent"),
        *("overlap_memory", "initial_packing", "orientations", "threads"),
    )

    system: Literal["chute"] = declare("chute", description="which of the two systems")
    depth: Real = declare(
        5,
        symbol="n",
        unit="1",
        description="depth of the flow: particles per squared diameter of plane",
        equation="Walton, Sec. 3: n = N/σ²",
        id_part="depth",
        gt=0,
    )
    friction: Real = declare(
        0.4,
        symbol="μ",
        unit="1",
        description="friction coefficient between particles",
        equation="Walton, Sec. 2.2: |T| ≤ μ F_N",
        id_part="friction",
        ge=0,
    )
    friction_plane: Real = declare(
        symbol="μ_p",
        unit="1",
        description="friction coefficient between particles and plane (omitted: friction)",
        equation="Walton, Sec. 3",
        ge=0,
        default_factory=lambda given: given["friction"],
    )
    restitution: Real = declare(
        0.85,
        symbol="e",
        unit="1",
        description="normal coefficient of restitution, the same at every impact velocity",
        equation="Walton, Sec. 2.1: e = √(K1/K2)",
        id_part="restitution",
        ge=0.001,
        le=1,
    )
    stiffness: Real = declare(
        100,
        symbol="K1",
        unit="N m-1",
        description="normal stiffness in loading",
        equation="Walton, Sec. 2.1: F_N = K1 α",
        id_part="stiffness",
        gt=0,
    )
    law: Literal["walton_braun", "spring_dashpot"] = declare(
        "walton_braun",
        description="contact law: Walton and Braun's, or the linear spring and dashpot with a "
        "linear tangential spring that most DEM codes use",
        equation="Walton, Sec. 2; Cundall and Strack (1979)",
        role="reading",
        compiled=True,
    )
    tangential_ratio: Real = declare(
        0.8,
        symbol="K0/K1",
        unit="1",
        description="initial tangential stiffness relative to the normal stiffness",
        equation="Walton, Eq. 1",
        role="reading",
        gt=0,
    )
    tangential_exponent: Real = declare(
        1 / 3,
        symbol="γ",
        unit="1",
        description="exponent of the tangential stiffness (0: linear spring)",
        equation="Walton, Eq. 1",
        role="reading",
        compiled=True,
        ge=0,
    )
    angle: Real = declare(
        17,
        symbol="θ",
        unit="degree",
        description="inclination of the plane",
        equation="Walton, Sec. 3",
        ge=0,
        lt=90,
    )
    cell: Real = declare(
        symbol="L",
        unit="1",
        scale="σ",
        description="side of the periodic cell (omitted: 10 up to depth 10, 5 above)",
        equation="Walton, Sec. 3, Figs. 1.1-1.6",
        role="numerics",
        changes_start=True,
        ge=3,
        default_factory=lambda given: 10 if given["depth"] <= 10 else 5,
    )
    diameter: Real = declare(
        1e-3,
        symbol="σ",
        unit="m",
        description="diameter of a particle",
        equation="Walton, Sec. 3",
        gt=0,
    )
    mass: Real = declare(
        1.492e-6,
        symbol="m",
        unit="kg",
        description="mass of a particle",
        equation="Walton, Sec. 3",
        gt=0,
    )
    diameter_spread: Real = declare(
        0,
        symbol="Δσ/σ",
        unit="1",
        scale="σ",
        description="half width of the uniform distribution of diameters, which are scaled so that "
        "the mean mass is mass (the paper: 0)",
        equation="Walton, Sec. 3",
        ge=0,
        le=0.5,
    )
    bumps: Real = declare(
        0,
        symbol="d_b",
        unit="1",
        scale="σ",
        description="diameter of the spheres glued to the plane at random places (0: none)",
        equation="Walton, Sec. 3: various degrees of roughness",
        ge=0,
        le=3,
    )
    bump_coverage: Real = declare(
        0.4,
        symbol="c_b",
        unit="1",
        description="share of the plane that the glued spheres cover, seen from above",
        ge=0.01,
        le=0.45,
    )
    gravity: Real = declare(
        9.8,
        symbol="g",
        unit="m s-2",
        description="gravitational acceleration",
        equation="Walton, Sec. 3",
        gt=0,
    )
    initial_packing: Real = declare(
        0.32,
        symbol="φ0",
        unit="1",
        description="packing fraction of the random initial state",
        equation="Walton, Sec. 1: 0.4 or less",
        role="numerics",
        ge=0.001,
        le=0.35,
    )
    initial_velocity: Real = declare(
        symbol="V0",
        unit="1",
        scale="√(gσ)",
        description="uniform initial velocity down the slope (omitted: 4 + 1.2 depth, at most 30)",
        equation="Walton, Sec. 1: slightly above the expected steady velocity",
        role="numerics",
        changes_start=True,
        ge=0,
        default_factory=lambda given: min(4 + 1.2 * given["depth"], 30),
    )
    initial_agitation: Real = declare(
        0.1,
        symbol="u0",
        unit="1",
        scale="√(gσ)",
        description="root mean square of the random initial velocities",
        equation="Walton, Sec. 1",
        role="numerics",
        ge=0,
    )
    steps_per_collision: int = declare(
        40,
        symbol="t_c/Δt",
        unit="1",
        description="time steps in one binary collision",
        equation="t_c = (π/2) √(m/2K1) (1 + e)",
        role="numerics",
        ge=10,
        le=1000,
    )
    transient: Real = declare(
        300,
        symbol="t_tr",
        unit="1",
        scale="√(σ/g)",
        description="time discarded before averaging",
        equation="Walton, Sec. 1",
        role="numerics",
        ge=0,
    )
    average: Real = declare(
        200,
        symbol="t_av",
        unit="1",
        scale="√(σ/g)",
        description="time averaged over",
        equation="Walton, Sec. 1",
        role="amount",
        gt=0,
    )
    limit: Real = declare(
        3000,
        symbol="t_max",
        unit="1",
        scale="√(σ/g)",
        description="longest run of the converged protocol, whose cost `points` tells",
        role="amount",
        gt=0,
    )
    sample_interval: Real = declare(
        0.25,
        symbol="Δt_s",
        unit="1",
        scale="√(σ/g)",
        description="time between two samples of the observables",
        role="numerics",
        gt=0,
        le=100,
    )
    slice_height: Real = declare(
        0.25,
        symbol="Δz",
        unit="1",
        scale="σ",
        description="height of the slices of the profiles",
        equation="Walton, Figs. 1.1-1.6",
        role="numerics",
        ge=0.01,
    )
    stress_profiles: bool = declare(
        False,
        description="also keep profiles of stress, spin and slip, and how the profiles change "
        "with time",
        role="numerics",
        compiled=True,
        added=True,
    )
    trajectory: Real = declare(
        0,
        symbol="Δt_f",
        unit="1",
        scale="√(σ/g)",
        description="time from one frame of the trajectory, which has the state of every particle, "
        "to the next (0: none); in whole samples",
        role="numerics",
        added=True,
        ge=0,
    )
    overlap_limit: Real = declare(
        0.25,
        symbol="α_lim",
        unit="1",
        scale="σ",
        description="overlap at which the run stops as unphysical (0.25: half a radius)",
        role="numerics",
        gt=0,
        le=0.95,
    )
    orientations: bool = declare(
        True,
        description="follow the orientations of the particles (changes no trajectory)",
        equation="Walton, Sec. 2",
        role="numerics",
        compiled=True,
    )
    threads: int = declare(
        1,
        unit="1",
        description="threads of one run (pays from some thousand particles on); the bits of the "
        "result depend on their number",
        role="numerics",
        ge=1,
        le=256,
    )
    overlap_memory: Literal["separation", "shrink", "reset"] = declare(
        "separation",
        description="the largest overlap of a contact is remembered until the particles separate, "
        "shrinks with the overlap once the force is zero, or is reset when the force is zero",
        equation="Walton, Sec. 2.1: α0",
        role="reading",
        compiled=True,
    )
    friction_cap: Literal["before", "after"] = declare(
        "before",
        description="a tangential force above the friction limit is cut before or after the "
        "tangential stiffness is evaluated",
        equation="Walton, Sec. 2.2",
        role="reading",
        compiled=True,
    )

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Say what may have been meant by a value."""
        if key == "law" and isinstance(value, str):
            return "a plug-in's, where plugins of the study or TALUS_PLUGINS name the plug-in"
        return ""

    @property
    def time_unit(self) -> float:
        """Time √(σ/g), s."""
        return math.sqrt(self.diameter / self.gravity)

    @property
    def collision_time(self) -> float:
        """Duration of a binary collision of the lightest particles, s, with m* = m/2.

        t_c = (π/2) √(m*/K1) (1 + e); of spring and dashpot π √(m*/K) √(1 + (ln e/π)²).
        """
        spread = self.diameter_spread
        lightest = self.mass * (1 - spread) ** 3 / (1 + spread**2)
        loading = math.pi / 2 * math.sqrt(lightest / 2 / self.stiffness)
        if self.law == "spring_dashpot":
            return 2 * loading * math.hypot(1, math.log(self.restitution) / math.pi)
        return loading * (1 + self.restitution)

    @property
    def time_step(self) -> float:
        """Time step, s."""
        return self.collision_time / self.steps_per_collision

    @property
    def limits(self) -> dict[str, tuple[float, str]]:
        """Accelerations (m s⁻²) of a block that slides and of a sphere that rolls alone."""
        slope = math.radians(self.angle)
        along, across = self.gravity * math.sin(slope), self.gravity * math.cos(slope)
        return {
            "sliding_acceleration": (
                along - self.friction_plane * across,
                "acceleration of a block that slides on the plane, g (sin θ - μ cos θ)",
            ),
            "rolling_acceleration": (
                5 / 7 * along,
                "acceleration of a sphere that rolls alone, (5/7) g sin θ",
            ),
        }

    @property
    def sample_steps(self) -> int:
        """Time steps between two samples, at least one."""
        return max(1, round(self.sample_interval * self.time_unit / self.time_step))

    @property
    def period(self) -> float:
        """Length along x after which all comes again, m."""
        return self.cell * self.diameter

    @property
    def particles(self) -> int:
        """Particles in the cell: depth times the cell's area in squared diameters."""
        return max(1, round(self.depth * self.cell * self.cell))

    @property
    def glued(self) -> int:
        """Spheres glued to the plane: their circles cover the share of it that is wanted."""
        if not self.bumps:
            return 0
        return max(1, round(self.bump_coverage * self.cell**2 / self._covered_by_a_bump))

    @property
    def _covered_by_a_bump(self) -> float:
        """Area of a glued sphere's circle in squared diameters; 0 where it is below all numbers."""
        return math.pi / 4 * self.bumps**2

    @property
    def caveat(self) -> str:
        """Say so when the start is faster than the contact law bears.

        Spheres that meet head-on at a speed v overlap by v √(m/2K1); sheared from bottom to top, a
        flow has spheres that differ by half of its velocity.
        """
        speed = 0.5 * abs(self.initial_velocity) * self.velocity_unit
        overlap = speed * math.sqrt(0.5 * self.mass / self.stiffness) / self.diameter
        return f"impacts at half its start velocity {_TOO_SOFT}" if overlap > SMALL else ""

    def caveat_of(self, overlap: float) -> str:
        """Say so when spheres have overlapped by more than the contact law bears."""
        return f"spheres {_TOO_SOFT}" if overlap > SMALL else ""

    @property
    def cores(self) -> int:
        """Cores that a run can keep busy: one per thread."""
        return self.threads

    @property
    def rate(self) -> float:
        """Particle-steps per second, about."""
        return RATE * (max(RATE_DEPTH, self.depth) / RATE_DEPTH) ** RATE_EXPONENT

    @model_validator(mode="after")
    def _of_one_mass_for_dashpots(self) -> Self:
        # The damping that gives the restitution wanted depends on the masses of both partners.
        if self.law == "spring_dashpot":
            for name in ("diameter_spread", "bumps"):
                if getattr(self, name):
                    raise broken_rule(name, getattr(self, name), "0 with law: spring_dashpot")
        return self

    @model_validator(mode="after")
    def _of_resolved_motion(self) -> Self:
        longest = max(self.sample_interval, self.transient + self.average) * self.time_unit
        if not self.time_step <= longest:
            allowed = "a value that gives a time step shorter than the run"
            raise broken_rule("stiffness", self.stiffness, allowed)
        return self

    @model_validator(mode="after")
    def _of_feasible_count(self) -> Self:
        if not self.depth * self.cell * self.cell <= MAX_PARTICLES:
            allowed = f"a value that gives at most {MAX_PARTICLES:.0e} particles in the cell"
            raise broken_rule("depth", self.depth, allowed)
        room = (MAX_PARTICLES - self.particles) * self._covered_by_a_bump
        if self.bumps and not self.bump_coverage * self.cell**2 <= room:
            allowed = (
                f"a value that gives at most {MAX_PARTICLES:.0e} particles, glued ones included"
            )
            raise broken_rule("bumps", self.bumps, allowed)
        return self

    @model_validator(mode="after")
    def _of_feasible_trajectory(self) -> Self:
        # The last rule: those before it make sure that the numbers of particles are feasible.
        require_feasible_trajectory(self)
        return self
