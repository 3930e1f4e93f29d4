"""Parameters of the inclined chute; defaults are those of Walton (1993)."""

import math
from typing import ClassVar, Literal

from sim.parameters.common import Real
from sim.parameters.roles import rows_of
from sim.parameters.spheres import SphereParameters

row = rows_of("chute")


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

    system: Literal["chute"] = row("system")
    angle: Real = row("angle")
    initial_velocity: Real = row(
        "initial_velocity",
        default_factory=lambda values: (
            0 if values["initial_state"] else min(4 + 1.2 * values["depth"], 30)
        ),
    )
    transient: Real = row("transient")
    average: Real = row("average")
    limit: Real = row("limit")
    sample_interval: Real = row("sample_interval")
    trajectory: Real = row("trajectory")

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

    def require_rules(self) -> None:
        super().require_rules()
        allowed = f"at least sample_interval = {self.sample_interval:g}"
        self.require("average", self.average >= self.sample_interval, allowed)
        is_short = self.time_step <= (self.transient + self.average) * self.time_unit
        self.require("stiffness", is_short, "a value that gives a time step shorter than the run")
