"""Parameters of the inclined chute; defaults are those of Walton (1993)."""

import math
from typing import ClassVar, Literal, Self

from pydantic import model_validator

from sim.parameters.common import Real, broken_rule, require_feasible_trajectory
from sim.parameters.roles import declare
from sim.parameters.spheres import SphereParameters


def negligible_acceleration(gravity: float, angle: float) -> float:
    """Return the acceleration (m s⁻²) that counts as zero at an angle (degree): 1 % of g sin θ.

    The sine counts as at least 0.1.
    """
    return 0.01 * gravity * max(math.sin(math.radians(angle)), 0.1)


class ChuteParameters(SphereParameters):
    """Spheres flowing down an inclined frictional plane (Walton 1993).

    Lengths in diameters, times in √(σ/g) and velocities in √(gσ) where the description says so;
    everything else is SI. Properties return SI.
    """

    sampling_key: ClassVar[str] = "sample_interval"
    boundaries: ClassVar[tuple[str, ...]] = ("flow", "acceleration")

    system: Literal["chute"] = declare("chute", description="which of the systems")
    angle: Real = declare(
        17,
        symbol="θ",
        unit="degree",
        description="inclination of the plane",
        equation="Walton, Sec. 3",
        ge=0,
        lt=90,
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
        default_factory=lambda values: min(4 + 1.2 * values["depth"], 30),
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

    @property
    def time_unit(self) -> float:
        """Time √(σ/g), s."""
        return math.sqrt(self.diameter / self.gravity)

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
    def caveat(self) -> str:
        """Warning of a start that is too fast for the contact law, or an empty text.

        In a flow sheared from bottom to top, colliding spheres differ by up to half its velocity.
        """
        speed = 0.5 * abs(self.initial_velocity) * self.velocity_unit
        return self._caveat_at(speed, "half its start velocity")

    @model_validator(mode="after")
    def _require_resolved_motion(self) -> Self:
        if not self.average >= self.sample_interval:
            allowed = f"at least sample_interval = {self.sample_interval:g}"
            raise broken_rule("average", self.average, allowed)
        if not self.time_step <= (self.transient + self.average) * self.time_unit:
            allowed = "a value that gives a time step shorter than the run"
            raise broken_rule("stiffness", self.stiffness, allowed)
        return self

    @model_validator(mode="after")
    def _require_feasible_trajectory(self) -> Self:
        # The last rule, as the rules before it bound the numbers of particles.
        require_feasible_trajectory(self)
        return self
