"""Parameters of particles on a vibrating plane, level or inclined."""

import math
from typing import Any, ClassVar, Literal, Self

from pydantic import model_validator

from sim.parameters.common import Real, broken_rule, require_feasible_trajectory
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
    smallest: ClassVar[dict[str, Any]] = {"depth": 0.2, "cell": 5, "steps_per_collision": 10}
    kept: ClassVar[tuple[str, ...]] = (*SphereParameters.kept, "shape", "rotation")

    # No paper has a recipe for it.
    sliding_direction: SlidingDirection = declare("slip", **SLIDING)
    system: Literal["conveyor"] = declare("conveyor", description="which of the systems")
    frequency: Real = declare(
        20,
        symbol="f",
        unit="Hz",
        description="frequency of the vibration",
        equation="ω = 2πf",
        id_part="frequency",
        gt=0,
    )
    amplitude: Real = declare(
        1,
        symbol="A_z",
        unit="1",
        scale="σ",
        description="amplitude of the vibration normal to the plane",
        equation="z = A_z sin ωt",
        id_part="amplitude",
        ge=0,
    )
    amplitude_along: Real = declare(
        1,
        symbol="A_x",
        unit="1",
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
        unit="1",
        description="second frequency of the vibration, in multiples of the first",
        ge=2,
        le=20,
    )
    overtone_amplitude: Real = declare(
        0,
        symbol="B_z",
        unit="1",
        scale="σ",
        description="amplitude normal to the plane at the second frequency",
        ge=0,
    )
    overtone_along: Real = declare(
        0,
        symbol="B_x",
        unit="1",
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
    angle: Real = declare(
        0,
        symbol="θ",
        unit="degree",
        description="inclination of the plane",
        ge=0,
        lt=90,
    )
    shape: Literal["sphere", "disc"] = declare(
        "sphere",
        description="solid spheres, or discs that move in the plane of x and z alone",
        compiled=True,
    )
    rotation: bool = declare(
        True,
        description="whether the particles rotate",
    )
    initial_velocity: Real = declare(
        0,
        symbol="V0",
        unit="1",
        scale="√(gσ)",
        description="velocity along the plane of all particles when the vibration starts",
        role="numerics",
        changes_start=True,
        ge=0,
    )
    samples_per_cycle: int = declare(
        20,
        unit="1",
        description="samples of the observables in one cycle",
        role="numerics",
        ge=1,
        le=1000,
    )
    transient: Real = declare(
        60,
        symbol="t_tr",
        unit="1",
        scale="cycles",
        description="length discarded before averaging, the fall onto the plane included",
        role="numerics",
        ge=0,
    )
    average: Real = declare(
        60,
        symbol="t_av",
        unit="1",
        scale="cycles",
        description="length averaged over",
        role="amount",
        gt=0,
    )
    limit: Real = declare(
        1500,
        symbol="t_max",
        unit="1",
        scale="cycles",
        description="longest run of the converged protocol, whose cost `points` tells",
        role="amount",
        gt=0,
    )
    trajectory: Real = declare(
        0,
        symbol="Δt_f",
        unit="1",
        scale="cycles",
        description="time from one frame of the trajectory, which has the state of every particle, "
        "to the next (0: none); in whole samples",
        role="numerics",
        added=True,
        ge=0,
    )

    @property
    def time_unit(self) -> float:
        """Period of the vibration, s."""
        return 1 / self.frequency

    @property
    def sample_steps(self) -> int:
        """Time steps between two samples: as few as resolve a collision and divide a cycle."""
        wanted = self.collision_time / self.steps_per_collision
        return max(1, math.ceil(self.time_unit / self.samples_per_cycle / wanted))

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
        """Velocity that transport is measured by, m/s: the largest of the plane along x.

        Of a plane that moves along z alone, that; 0.01 σ is the least amplitude that counts.
        """
        along, normal = self.peak_velocity
        least = 0.02 * math.pi * self.frequency * self.diameter
        return max(along or normal, least)

    @property
    def limits(self) -> dict[str, tuple[float, str]]:
        """Largest acceleration of the plane normal to it (m s⁻²), of the first frequency alone."""
        rate = 2 * math.pi * self.frequency
        peak = rate * rate * self.amplitude * self.diameter
        return {"plane_acceleration": (peak, "peak acceleration of the plane along z, A_z ω²")}

    @property
    def caveat(self) -> str:
        """Say so when the plane is faster than the contact law bears."""
        speed = sum(self.peak_velocity) + abs(self.initial_velocity) * self.velocity_unit
        return self._caveat_at(0.5 * speed, "half the velocity of the plane")

    @property
    def is_flat(self) -> bool:
        """Whether all particles lie in one plane, y = 0: discs."""
        return self.shape == "disc"

    @property
    def _breadth(self) -> float:
        """Side of the cell across the flow, in diameters; discs lie in one row."""
        return 1.0 if self.is_flat else self.cell

    @property
    def _covered_by_a_bump(self) -> float:
        """What a glued particle covers of the plane, in squared diameters or, of discs, its row."""
        return self.bumps if self.is_flat else super()._covered_by_a_bump

    @model_validator(mode="after")
    def _of_spheres_alone(self) -> Self:
        if self.is_flat and self.stress_profiles:
            allowed = "false with shape: disc: none of its stresses is per area"
            raise broken_rule("stress_profiles", self.stress_profiles, allowed)
        return self

    @model_validator(mode="after")
    def _of_feasible_trajectory(self) -> Self:
        # The last rule: those before it make sure that the numbers of particles are feasible.
        require_feasible_trajectory(self)
        return self
