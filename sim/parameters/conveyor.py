"""Parameters of particles on a vibrating plane, level or inclined."""

import math
from typing import Any, ClassVar, Literal

from sim.parameters import roles
from sim.parameters.common import Real, broken_rule
from sim.parameters.roles import declare
from sim.parameters.spheres import SLIDING, SlidingDirection, SphereParameters


class ConveyorParameters(SphereParameters):
    """Spheres or discs with any law of the chute on a plane that vibrates.

    The plane moves along x = A_x sin(ωt + φ_x) + B_x sin(kωt + ψ) down its slope, and normal to it
    along z = A_z sin ωt + B_z sin(kωt + ψ): straight, elliptic and circular motions, and those of
    two frequencies. Lengths in diameters, times in cycles, velocities in √(gσ); properties SI.
    """

    sampling_key: ClassVar[str] = "samples_per_cycle"
    boundaries: ClassVar[tuple[str, ...]] = ("flow", "transport")
    smallest_values: ClassVar[dict[str, Any]] = {"depth": 0.2, "cell": 5, "steps_per_collision": 10}
    fixed_parameters: ClassVar[tuple[str, ...]] = (
        *SphereParameters.fixed_parameters,
        "shape",
        "rotation",
    )

    # No paper prescribes it.
    sliding_direction: SlidingDirection = declare("slip", **SLIDING)
    system: Literal["conveyor"] = declare("conveyor", description="which of the systems")
    frequency: Real = roles.frequency(equation="ω = 2πf")
    amplitude: Real = declare(
        1,
        symbol="A_z",
        scale="σ",
        description="amplitude of the vibration normal to the plane",
        equation="z = A_z sin ωt",
        id_part="amplitude",
        ge=0,
    )
    amplitude_along: Real = declare(
        1,
        symbol="A_x",
        scale="σ",
        description="amplitude of the vibration along the plane",
        equation="x = A_x sin(ωt + φ_x)",
        id_part="along",
        ge=0,
    )
    phase_along: Real = declare(
        0,
        symbol="φ_x",
        unit="degree",
        description="phase by which the motion along the plane leads (0: straight, 90 with equal "
        "amplitudes: circular)",
        equation="x = A_x sin(ωt + φ_x)",
        ge=0,
        lt=360,
    )
    overtone: int = declare(
        2,
        symbol="k",
        description="second frequency of the vibration, in multiples of the first",
        ge=2,
        le=20,
    )
    overtone_amplitude: Real = declare(
        0,
        symbol="B_z",
        scale="σ",
        description="amplitude normal to the plane at the second frequency",
        ge=0,
    )
    overtone_along: Real = declare(
        0,
        symbol="B_x",
        scale="σ",
        description="amplitude along the plane at the second frequency",
        ge=0,
    )
    overtone_phase: Real = declare(
        0,
        symbol="ψ",
        unit="degree",
        description="phase of the vibration at the second frequency",
        ge=0,
        lt=360,
    )
    angle: Real = roles.angle(0)
    shape: Literal["sphere", "disc"] = declare(
        "sphere",
        description="solid spheres, or discs that move in the plane of x and z alone",
        compiled=True,
    )
    rotation: bool = declare(True, description="whether the particles rotate")
    initial_velocity: Real = roles.initial_velocity(
        0,
        scale="√(gσ)",
        description="velocity along the plane of all particles when the vibration starts",
    )
    samples_per_cycle: int = roles.samples_per_cycle(
        description="samples of the observables in one cycle", le=1000
    )
    transient: Real = roles.transient(
        60,
        scale=roles.CYCLES,
        description="length discarded before averaging, the fall onto the plane included",
    )
    average: Real = roles.average(60, scale=roles.CYCLES, description="length averaged over")
    limit: Real = roles.limit(1500, scale=roles.CYCLES)
    trajectory: Real = roles.trajectory(scale=roles.CYCLES)

    @property
    def time_unit(self) -> float:
        """Period of the vibration, s."""
        return 1 / self.frequency

    @property
    def sample_steps(self) -> int:
        """Time steps between two samples: as few as resolve a collision and divide a cycle."""
        longest = self.collision_time / self.steps_per_collision
        return max(1, math.ceil(self.time_unit / self.samples_per_cycle / longest))

    @property
    def time_step(self) -> float:
        """Time step, s: a whole part of a cycle, at most a collision over steps_per_collision."""
        return self.time_unit / self.samples_per_cycle / self.sample_steps

    @property
    def peak_velocity(self) -> tuple[float, float]:
        """Bounds of the velocity of the plane along x and z, m/s."""
        rate = 2 * math.pi * self.frequency * self.diameter
        return (
            rate * (self.amplitude_along + self.overtone * self.overtone_along),
            rate * (self.amplitude + self.overtone * self.overtone_amplitude),
        )

    @property
    def velocity_amplitude(self) -> float:
        """Unit of transport velocities, m/s: the plane's largest velocity along x.

        For a plane that moves only along z, it is the largest velocity along z. Amplitudes below
        0.01 σ count as 0.01 σ.
        """
        along, normal = self.peak_velocity
        least = 0.02 * math.pi * self.frequency * self.diameter
        return max(along or normal, least)

    @property
    def limits(self) -> dict[str, tuple[float, str]]:
        """Largest normal acceleration of the plane (m s⁻²) at the first frequency alone."""
        rate = 2 * math.pi * self.frequency
        peak = rate * rate * self.amplitude * self.diameter
        return {"plane_acceleration": (peak, "peak acceleration of the plane along z, A_z ω²")}

    @property
    def caveat(self) -> str:
        """Warning of a plane that is too fast for the contact law, or an empty text."""
        speed = sum(self.peak_velocity) + abs(self.initial_velocity) * self.velocity_unit
        return self._caveat_at(0.5 * speed, "half the velocity of the plane")

    @property
    def is_flat(self) -> bool:
        """True for discs: all particles lie in one plane, y = 0."""
        return self.shape == "disc"

    @property
    def _breadth(self) -> float:
        """Side of the cell across the flow, in diameters; 1 for discs, which lie in one row."""
        return 1.0 if self.is_flat else self.cell

    @property
    def _bump_area(self) -> float:
        """Area under a glued particle in squared diameters; for discs its diameter."""
        return self.bumps if self.is_flat else super()._bump_area

    def require_rules(self) -> None:
        """Raise for values that do not go together."""
        super().require_rules()
        if self.is_flat and self.stress_profiles:
            allowed = "false with shape: disc: none of its stresses is per area"
            raise broken_rule("stress_profiles", self.stress_profiles, allowed)
