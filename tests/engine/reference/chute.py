"""Spheres on an inclined frictional plane, all pairs, leap-frog (Walton 1993, section 2).

The plane is z = 0, x points down the slope, x and y are periodic, gravity is tilted. Without a
plane, a box or gravity the same code follows free spheres.
"""

from dataclasses import dataclass, field

import numpy as np

from .laws import Contact, ContactLaw, FunctionLaw, SpringDashpotLaw

Law = ContactLaw | SpringDashpotLaw | FunctionLaw

PLANE = -1
"""Stands for particle j in the key of a contact with the plane."""


@dataclass
class Spheres:
    """Positions at step n, velocities and spins at step n - 1/2, and the contacts of step n.

    position (N, 3) m, velocity (N, 3) m/s, spin (N, 3) rad/s, radius (N,) m, mass (N,) kg.
    contacts maps (i, j) with i < j, or (i, PLANE), to what that contact remembers; after a step
    it holds the contacts in which the forces of that step acted.
    """

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    contacts: dict[tuple[int, int], Contact] = field(default_factory=dict)


@dataclass(frozen=True)
class Chute:
    """The surroundings: law of the pairs, law of the plane, cell edges and gravity.

    plane_law None means no plane, box None an unbounded space; box is the edge length (m) in x
    and y; gravity is a vector (m/s2). The arms of torques of pairs are radii, less a share of the
    overlap (shortened), as another engine has it.
    """

    law: Law
    plane_law: Law | None = None
    box: tuple[float, float] | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shortened: float = 0.0


def tilted(gravity: float, angle: float) -> tuple[float, float, float]:
    """Gravity vector (m/s2) on a plane inclined by angle (degrees)."""
    slope = np.radians(angle)
    return (gravity * float(np.sin(slope)), 0.0, -gravity * float(np.cos(slope)))


def collision_time(law: ContactLaw, mass: float) -> float:
    """Duration t_c (s) of a collision of two spheres of this mass (kg), with m* = m/2."""
    return 0.5 * np.pi * np.sqrt(0.5 * mass / law.stiffness) * (1.0 + law.restitution)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector product of two vectors (3)."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def nearest_image(separation: np.ndarray, box: tuple[float, float] | None) -> np.ndarray:
    """Separations (..., 3) brought to the nearest periodic image in x and y."""
    if box is None:
        return separation
    edges = np.array([box[0], box[1], np.inf])
    shift = np.where(np.isinf(edges), 0.0, edges) * np.round(separation / edges)
    return separation - shift


def touching(spheres: Spheres, chute: Chute) -> list[tuple[int, int, float, np.ndarray]]:
    """Every contact as (i, j, overlap, k_hat), pairs first, then those with the plane."""
    found = []
    for i in range(len(spheres.position) - 1):
        others = spheres.position[i + 1 :] - spheres.position[i]
        separation = nearest_image(others, chute.box)
        distance = np.sqrt(np.sum(separation**2, axis=1))
        overlap = spheres.radius[i] + spheres.radius[i + 1 :] - distance
        for other in np.flatnonzero(overlap > -reach_of(chute.law)):
            k_hat = separation[other] / distance[other]
            found.append((i, i + 1 + int(other), float(overlap[other]), k_hat))
    if chute.plane_law is not None:
        for i, overlap in enumerate(spheres.radius - spheres.position[:, 2]):
            if overlap > -reach_of(chute.plane_law):
                found.append((i, PLANE, float(overlap), np.array([0.0, 0.0, -1.0])))
    return found


def reach_of(law: Law) -> float:
    """How far (m) beyond contact a law acts."""
    return getattr(law, "reach", 0.0)


def surface_velocity(spheres: Spheres, i: int, j: int, k_hat: np.ndarray) -> np.ndarray:
    """Velocity (3, m/s) of the surface of j relative to that of i; its k_hat part is not removed.

    The plane rests: it has neither a velocity nor a spin.
    """
    velocity = -spheres.velocity[i]
    roll = spheres.radius[i] * spheres.spin[i]
    if j != PLANE:
        velocity = velocity + spheres.velocity[j]
        roll = roll + spheres.radius[j] * spheres.spin[j]
    return velocity - cross(roll, k_hat)


def forces(spheres: Spheres, chute: Chute, time_step: float) -> tuple[np.ndarray, np.ndarray, dict]:
    """Contact forces (N, 3), torques (N, 3) and the new contacts, for the present positions.

    time_step (s) turns the velocities of the last half step into the displacement of the step.
    """
    force = np.zeros_like(spheres.position)
    torque = np.zeros_like(spheres.position)
    contacts = {}
    for i, j, overlap, k_hat in touching(spheres, chute):
        law = chute.plane_law if j == PLANE else chute.law
        slip = time_step * surface_velocity(spheres, i, j, k_hat)
        old = spheres.contacts.get((i, j), Contact())
        partners = [i] if j == PLANE else [i, j]
        spin = np.zeros(3) if j == PLANE else spheres.spin[j]
        turn = time_step * (spin - spheres.spin[i])
        radius, mass = (1 / np.sum(1 / one[partners]) for one in (spheres.radius, spheres.mass))
        normal_force, shear, new = law.update(old, overlap, k_hat, slip, turn, radius, mass)
        contacts[i, j] = new
        on_i = shear - normal_force * k_hat
        force[i] += on_i
        less = 0.0 if j == PLANE else chute.shortened * overlap
        torque[i] += (spheres.radius[i] - less) * cross(k_hat, shear) + new.torque
        if j != PLANE:
            force[j] -= on_i
            torque[j] += (spheres.radius[j] - less) * cross(k_hat, shear) - new.torque
    return force, torque, contacts


def step(spheres: Spheres, chute: Chute, time_step: float) -> Spheres:
    """One leap-frog step: kick from n - 1/2 to n + 1/2, then drift from n to n + 1."""
    force, torque, contacts = forces(spheres, chute, time_step)
    inertia = 0.4 * spheres.mass * spheres.radius**2
    acceleration = force / spheres.mass[:, None] + np.array(chute.gravity)
    velocity = spheres.velocity + time_step * acceleration
    spin = spheres.spin + time_step * torque / inertia[:, None]
    position = spheres.position + time_step * velocity
    return Spheres(position, velocity, spin, spheres.radius, spheres.mass, contacts)


def run(spheres: Spheres, chute: Chute, time_step: float, steps: int) -> Spheres:
    """The spheres after a number of steps."""
    for _ in range(steps):
        spheres = step(spheres, chute, time_step)
    return spheres
