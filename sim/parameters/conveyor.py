"""Parameters of particles on a vibrating plane, level or inclined."""

import math
from typing import Any, ClassVar, Literal

from sim.parameters.common import Parameters, Real, in_place
from sim.parameters.roles import rows_of
from sim.parameters.spheres import SlidingDirection, SphereParameters

row = rows_of("conveyor")


class ConveyorParameters(SphereParameters):
    """Spheres or discs with any law of the chute on a plane that vibrates.

    The plane moves along x = A_x sin(ωt + φ_x) + B_x sin(kωt + ψ) down its slope, and normal to it
    along z = A_z sin ωt + B_z sin(kωt + ψ): straight, elliptic and circular motions, and those of
    two frequencies. Lengths in diameters, times in cycles, velocities in √(gσ); properties SI.
    """

    sampling_key: ClassVar[str] = "samples_per_cycle"
    boundaries: ClassVar[tuple[str, ...]] = ("flow", "transport")
    smallest_values: ClassVar[dict[str, Any]] = {"depth": 0.2, "cell": 5, "steps_per_collision": 10}
    in_place: ClassVar[dict[str, Any]] = Parameters.in_place | {
        name: in_place(name) for name in ("stroke", "vibration_angle")
    }
    # No paper prescribes it.
    sliding_direction: SlidingDirection = row("sliding_direction")
    system: Literal["conveyor"] = row("system")
    frequency: Real = row("frequency")
    amplitude: Real = row("amplitude")
    amplitude_along: Real = row("amplitude_along")
    phase_along: Real = row("phase_along")
    overtone: int = row("overtone")
    overtone_amplitude: Real = row("overtone_amplitude")
    overtone_along: Real = row("overtone_along")
    overtone_phase: Real = row("overtone_phase")
    angle: Real = row("angle")
    shape: Literal["sphere", "disc"] = row("shape")
    rotation: bool = row("rotation")
    initial_velocity: Real = row("initial_velocity")
    samples_per_cycle: int = row("samples_per_cycle")
    transient: Real = row("transient")
    average: Real = row("average")
    limit: Real = row("limit")
    trajectory: Real = row("trajectory")

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
    def throw_number(self) -> float:
        """Largest normal acceleration of the plane over gravity's, A_z ω²/(g cos θ)."""
        peak, _ = self.limits["plane_acceleration"]
        return peak / (self.gravity * math.cos(math.radians(self.angle)))

    @property
    def caveat(self) -> str:
        """Warning of a plane that is too fast for the contact law, or an empty text."""
        speed = sum(self.peak_velocity) + abs(self.initial_velocity) * self.velocity_unit
        return self._caveat_at(0.5 * speed, "half the velocity of the plane")

    @property
    def is_flat(self) -> bool:
        """True for discs."""
        return self.shape == "disc"

    @property
    def breadth(self) -> float:
        """Side of the cell across the flow, in diameters; 1 for discs, which lie in one row."""
        return 1.0 if self.is_flat else super().breadth

    @property
    def _bump_area(self) -> float:
        """Area under a glued particle in squared diameters; for discs its diameter."""
        return self.bumps if self.is_flat else super()._bump_area

    def require_rules(self) -> None:
        super().require_rules()
        allowed = "0 with shape: disc, which lie in one plane"
        self.require("cell_across", not (self.is_flat and self.cell_across), allowed)
        allowed = "false with shape: disc: none of its stresses is per area"
        self.require("stress_profiles", not (self.is_flat and self.stress_profiles), allowed)
