"""Bodies in motion: spheres and disks under the engine's kernels alone, and whole systems."""

import numpy as np

from sim.boundary.belt import Belt
from sim.boundary.obstacle import Obstacle
from sim.boundary.plane import make_plane
from sim.contact.spring_damping import SpringDamping
from sim.contact.walton_braun import WaltonBraun
from sim.dynamics import leap_frog, shaking
from sim.dynamics.disks import make_disks
from sim.dynamics.gear import Gear
from sim.dynamics.neighbors import empty_pair_list, grown, make_box
from sim.dynamics.orientation import unrotated
from sim.dynamics.spheres import make_spheres, make_work
from sim.dynamics.status import LIST_FULL, OK
from sim.parameters import Parameters, parse_point
from sim.systems import build
from tests.engine_helpers import (
    BEAD,
    BEAD_MASS,
    MASS,
    RADIUS,
    bead_law,
    collision_time,
    sphere_law,
)

AT_REST = Belt(0.0, 0.0, 0.0, 0.0, 0.0)
NO_OBSTACLE = Obstacle(0.0, 0.0, 0.0)


class SphereMotion:
    """Spheres above the plane under the engine's leap-frog, without a system around them."""

    def __init__(
        self,
        position,
        velocity,
        spin=0.0,
        *,
        law: WaltonBraun | None = None,
        plane_law: WaltonBraun | None = None,
        radius=RADIUS,
        mass=MASS,
        box=(0.0, 0.0),
        gravity=(0.0, 0.0, 0.0),
        steps_per_collision: float = 40,
        skin: float = 0.3 * 2 * RADIUS,
        room: int = 12,
        orientations: bool = False,
        overlap_limit: float = 0.5,
    ):
        law = law or sphere_law()
        self.laws = (law, plane_law or law)
        self.time_step = collision_time(law) / steps_per_collision
        self.spheres = make_spheres(np.array(position), np.array(velocity), radius, mass)
        self.spheres.spin[:] = spin
        number = len(self.spheres.mass)
        self.orientation = unrotated(number if orientations else 0)
        self.pairs = empty_pair_list(number, 3, skin, room)
        self.plane, self.work, self.flow = make_plane(number), make_work(), leap_frog.make_flow()
        self.box = make_box(*box, 0.0)
        self.gravity, self.overlap_limit = gravity, overlap_limit

    def advance(self, steps: int) -> int:
        """Advance by a number of steps, once; return the status."""
        return leap_frog.advance(
            self.laws,
            self.spheres,
            self.orientation,
            self.pairs,
            self.plane,
            self.box,
            self.work,
            self.flow,
            self.gravity,
            self.time_step,
            self.overlap_limit,
            steps,
        )

    def run(self, steps: int) -> "SphereMotion":
        """Advance by a number of steps, giving the list more room as needed."""
        return _run(self, self.flow, steps)

    def energy(self) -> float:
        """Kinetic energy of translation and rotation, J."""
        s = self.spheres
        moving = (s.mass[:, None] * s.velocity**2).sum()
        return 0.5 * float(moving + (s.inertia[:, None] * s.spin**2).sum())

    def momentum(self) -> np.ndarray:
        """Total momentum (3,), kg m/s."""
        return self.spheres.mass @ self.spheres.velocity

    def angular_momentum(self) -> np.ndarray:
        """Orbital angular momentum about the origin and that of the spins (3,), kg m2/s."""
        s = self.spheres
        orbital = s.mass @ np.cross(s.position, s.velocity)
        return orbital + s.inertia @ s.spin


class DiskMotion:
    """Disks above the belt under the engine's integrators, without a system around them.

    ``acceleration`` (m/s2) is what the integrator is told of the past; without it the first step is
    a little off, as with every predictor that starts from position and velocity alone.
    """

    def __init__(
        self,
        position,
        velocity,
        *,
        acceleration=0.0,
        law: SpringDamping | None = None,
        integrator=Gear,
        time_step: float = 2.5e-5,
        radius=0.5 * BEAD,
        mass=BEAD_MASS,
        width: float = 20 * BEAD,
        gravity: float = 0.0,
        belt: Belt = AT_REST,
        obstacle: Obstacle = NO_OBSTACLE,
        skin: float = 0.3 * BEAD,
        room: int = 12,
        overlap_limit: float = 0.95,
    ):
        self.law, self.integrator = law or bead_law(), integrator(time_step)
        self.disks = make_disks(position, velocity, radius, mass, time_step)
        self.disks.taylor[2] = 0.5 * np.asarray(acceleration) * time_step**2
        self.pairs = empty_pair_list(len(self.disks.mass), 2, skin, room)
        self.loop, self.box = shaking.make_shaking(), make_box(width, 0.0)
        self.belt, self.obstacle = belt, obstacle
        self.gravity, self.overlap_limit = gravity, overlap_limit

    @property
    def position(self) -> np.ndarray:
        """Positions (N, 2), m."""
        return self.disks.taylor[0]

    @property
    def velocity(self) -> np.ndarray:
        """Velocities (N, 2), m/s."""
        return self.disks.taylor[1] / self.integrator.time_step

    def advance(self, steps: int) -> int:
        """Advance by a number of steps, once; return the status."""
        return shaking.advance(
            self.law,
            self.integrator,
            self.disks,
            self.pairs,
            self.belt,
            self.obstacle,
            self.box,
            self.loop,
            self.gravity,
            self.overlap_limit,
            steps,
        )

    def run(self, steps: int) -> "DiskMotion":
        """Advance by a number of steps, giving the list more room as needed."""
        return _run(self, self.loop, steps)


def _run(motion, loop, steps: int):
    target = loop.step[0] + steps
    status = LIST_FULL
    while status == LIST_FULL:
        status = motion.advance(target - loop.step[0])
        if status == LIST_FULL:
            motion.pairs = grown(motion.pairs)
    assert status == OK
    return motion


def chute_point(**values) -> Parameters:
    """Parameters of the chute, changed."""
    return parse_point({"system": "chute", **values}, "test")


def belt_point(**values) -> Parameters:
    """Parameters of the belt, changed."""
    return parse_point({"system": "belt", **values}, "test")


def series_of(parameters: Parameters, replicate: int = 0) -> dict[str, np.ndarray]:
    """Time series (T,) of one replicate, transient and average."""
    system = build(parameters, replicate)
    system.settle()
    total = parameters.transient_samples + parameters.average_samples
    samples = [system.advance() for _ in range(total)]
    return {name: np.array([sample[name] for sample in samples]) for name in system.series}
