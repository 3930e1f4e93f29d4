"""Impacts of two spheres, or of one on the plane, each apart from the others."""

import numpy as np

from tests.engine_motion.spheres import SphereMotion

#: From the first sphere of a pair to the second one, and the way along which that slides.
NORMAL, TANGENT = np.array([0.6, 0.0, 0.8]), np.array([-0.64, 0.6, 0.48])


class Impacts:
    """Impacts that begin at different parts of a time step.

    ``radii`` (m) and ``mass`` (kg) are those of both spheres, or of the one that meets the plane.
    ``speeds`` (n,) are those along the normal (m/s) of n impacts, ``slides`` those along which the
    second surface slides, ``spins`` (n, p, 3) those of all spheres (1/s) along normal, tangent and
    the direction across both. The momenta of a pair cancel.
    """

    def __init__(self, law, radii, mass, time_step, speeds, slides=0.0, spins=0.0, frame=None):
        self.radii, self.mass = np.array(radii, float), np.array(mass, float)
        self.step, self.is_pair = time_step, len(radii) == 2
        first = [NORMAL, TANGENT] if self.is_pair else [[0, 0, -1.0], [0, 1.0, 0]]
        self.frame = np.array(first if frame is None else frame, float)
        self.axes = np.vstack([self.frame, np.cross(*self.frame)])
        normal, tangent = self.frame
        speeds = np.atleast_1d(np.array(speeds, float))
        slides = np.broadcast_to(slides, speeds.shape)
        self.start = slides[:, None] * tangent - speeds[:, None] * normal
        self.number = len(speeds)
        delays = self.step * np.linspace(0.1, 0.9, self.number)[:, None]
        place = np.arange(self.number)
        height = 30e-3 if self.is_pair else self.radii[0]
        corner = np.stack([6e-3 * (place % 9), 9e-3 * (place // 9), 0.0 * place + height], axis=1)
        if self.is_pair:
            shares = self.mass[::-1] / sum(self.mass)
            second = corner + sum(self.radii) * normal - delays * self.start
            position = np.stack([corner, second], axis=1).reshape(-1, 3)
            velocity = np.stack([-shares[0] * self.start, shares[1] * self.start], axis=1)
        else:
            position, velocity = corner + delays * self.start, -self.start
        spins = np.broadcast_to(spins, (self.number, len(self.radii), 3)) @ self.axes
        size, mass = (np.tile(values, self.number) for values in (self.radii, self.mass))
        self.motion = SphereMotion(
            position,
            velocity.reshape(-1, 3),
            spins.reshape(-1, 3),
            law=law,
            time_step=self.step,
            radius=size,
            mass=mass,
        )

    @property
    def touching(self) -> int:
        """Number of contacts in the last step."""
        return self.motion.contacts()[0].size + self.motion.plane_contacts()[0].size

    def run(self, steps: int) -> "Impacts":
        """Run for some steps, after which all must have parted."""
        self.motion.run(steps)
        assert not self.touching
        return self

    def run_until_parted(self, most: int = 20_000) -> "Impacts":
        """Run until all have met and parted, for so many steps at most."""
        met = 0
        for _ in range(most // 20):
            self.motion.run(20)
            touching = self.touching
            met = max(met, touching)
            if met == self.number and not touching:
                return self
        raise AssertionError("still in contact")

    def velocities(self) -> np.ndarray:
        """Return velocities of the second along normal and tangent, and all rims', m/s (n, 2 + p).

        Rims move along the tangent where they touch.
        """
        velocity = self.motion.velocity.reshape(self.number, -1, 3)
        relative = velocity[:, 1] - velocity[:, 0] if self.is_pair else -velocity[:, 0]
        rims = self.radii * (self.motion.spin.reshape(velocity.shape) @ self.axes[2])
        return np.hstack([relative @ self.frame.T, rims])

    def slips(self) -> np.ndarray:
        """Return the velocities of the surfaces along each other, m/s (n,)."""
        return self.velocities()[:, 1] - self.velocities()[:, 2:].sum(axis=1)
