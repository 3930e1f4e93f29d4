"""One contact of linear springs, a dashpot along the normal and a friction limit.

Cundall and Strack, Géotechnique 29 (1979) 47. Interface and signs are those of walton_braun.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from .walton_braun import Contact


@dataclass(frozen=True)
class SpringDashpotLaw:
    """Stiffness (N/m), restitution, friction, reduced mass (kg), time step (s), K_t/K.

    A normal force that would pull is kept, or clipped at 0: see `sim.parameters.dashpot`.
    """

    stiffness: float
    restitution: float
    friction: float
    mass: float
    time_step: float
    tangential_ratio: float = 0.8
    attraction: str = "kept"

    @property
    def damping(self) -> float:
        """Coefficient c (kg/s) of the damped oscillator that gives the restitution."""
        rate, critical = -np.log(self.restitution), 2 * np.sqrt(self.stiffness * self.mass)
        if self.attraction == "kept":
            return critical * rate / np.sqrt(np.pi**2 + rate**2)
        return critical * np.cos(brentq(lambda angle: 2 * angle / np.tan(angle) - rate, 1e-6, 1.57))

    def update(
        self, contact: Contact, overlap: float, k_hat: np.ndarray, slip: np.ndarray
    ) -> tuple[float, np.ndarray, Contact]:
        """Advance a contact by one step: normal force (N), T on particle i (3, N), new state."""
        closing = -float(slip @ k_hat) / self.time_step
        normal_force = self.stiffness * overlap + self.damping * closing
        if self.attraction == "clipped":
            normal_force = max(normal_force, 0.0)
        shear = contact.tangential_force
        tangent = shear - (shear @ k_hat) * k_hat
        if np.linalg.norm(tangent) > 0.0:
            tangent = tangent * np.linalg.norm(shear) / np.linalg.norm(tangent)
        tangent = tangent + self.tangential_ratio * self.stiffness * (slip - (slip @ k_hat) * k_hat)
        limit = self.friction * abs(normal_force)
        length = np.linalg.norm(tangent)
        if length > limit:
            tangent = tangent * limit / length
        return (
            normal_force,
            tangent,
            Contact(tangential_force=tangent, normal_force=normal_force),
        )
