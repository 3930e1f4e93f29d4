"""Disks on a vibrating belt, all pairs, linear spring with damping (Gallas et al. 1992, section 2).

x is periodic, z points up, disks do not rotate. The belt is a horizontal line that moves as a
whole; the obstacle is a disk fixed in the laboratory that the belt does not see.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import comb, factorial
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True)
class Belt:
    """Everything but the beads, in SI units.

    width L and mean_diameter <d> in m, stiffness Y in N/m, damping gamma and shear_damping
    gamma_s in 1/s, amplitude (A_x, A_z) in m, angular_frequency in rad/s, phase in rad,
    obstacle diameter in m (0 means none). A belt at rest has an angular_frequency and a phase of
    zero but keeps its amplitude, which also places the obstacle.

    damping_mass: "own" or "reduced" mass of the bead in the damping terms. belt_ghost: the belt
    acts as a disk of diameter <d> right "below" its line or "centred" on it, of ghost_mass (kg).
    attraction: a normal force that pulls is "kept" or "clipped" to zero.
    """

    width: float
    mean_diameter: float
    stiffness: float
    damping: float
    shear_damping: float
    gravity: float = 10.0
    amplitude: tuple[float, float] = (0.0, 0.0)
    angular_frequency: float = 0.0
    phase: float = 0.0
    obstacle: float = 0.0
    damping_mass: str = "own"
    belt_ghost: str = "below"
    ghost_mass: float = np.inf
    attraction: str = "kept"


def belt_motion(belt: Belt, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Position (2, m) and velocity (2, m/s) of the belt (equation 1)."""
    angle = belt.angular_frequency * time + belt.phase
    amplitude = np.array(belt.amplitude)
    return amplitude * np.sin(angle), amplitude * belt.angular_frequency * np.cos(angle)


def contact_force(
    belt: Belt,
    to_other: np.ndarray,
    relative_velocity: np.ndarray,
    touching_distance: float,
    damping_mass: float,
) -> np.ndarray:
    """Force (2, N) on bead i (equations 2 to 4), zero without an overlap.

    to_other points from i to its partner (m), relative_velocity is v_i - v_partner (m/s),
    touching_distance the mean of the two diameters (m), damping_mass the mass (kg) in the
    damping terms.
    """
    distance = np.sqrt(np.dot(to_other, to_other))
    if distance >= touching_distance:
        return np.zeros(2)
    r_hat = to_other / distance
    t_hat = np.array([-r_hat[1], r_hat[0]])
    normal = belt.stiffness * (distance - touching_distance)
    normal -= belt.damping * damping_mass * np.dot(relative_velocity, r_hat)
    if belt.attraction == "clipped":
        normal = min(normal, 0.0)
    shear = -belt.shear_damping * damping_mass * np.dot(relative_velocity, t_hat)
    return normal * r_hat + shear * t_hat


def touching(
    belt: Belt, diameter: np.ndarray, position: np.ndarray
) -> list[tuple[int, int, np.ndarray]]:
    """Every pair of beads that overlap, as (i, j, separation from i to j)."""
    found = []
    for i in range(len(position) - 1):
        separation = nearest_image(position[i + 1 :] - position[i], belt.width)
        reach = 0.5 * (diameter[i] + diameter[i + 1 :])
        close = np.sqrt(np.sum(separation**2, axis=1)) < reach
        for other in np.flatnonzero(close):
            found.append((i, i + 1 + int(other), separation[other]))
    return found


def damping_masses(belt: Belt, mass_i: float, mass_j: float) -> tuple[float, float]:
    """Masses (kg) in the damping terms of the force on i and of that on j."""
    if belt.damping_mass == "own":
        return mass_i, mass_j
    reduced = 1 / (1 / mass_i + 1 / mass_j)
    return reduced, reduced


def forces(
    belt: Belt,
    diameter: np.ndarray,
    mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    time: float,
) -> np.ndarray:
    """Contact forces (N, 2) on the beads, without their weight.

    diameter (N,) m, mass (N,) kg, position (N, 2) m, velocity (N, 2) m/s, time in s.
    """
    force = np.zeros_like(position)
    for i, j, to_other in touching(belt, diameter, position):
        relative = velocity[i] - velocity[j]
        reach = 0.5 * (diameter[i] + diameter[j])
        mass_i, mass_j = damping_masses(belt, mass[i], mass[j])
        force[i] += contact_force(belt, to_other, relative, reach, mass_i)
        force[j] += contact_force(belt, -to_other, -relative, reach, mass_j)
    for i in range(len(position)):
        force[i] += belt_force(belt, diameter[i], mass[i], position[i], velocity[i], time)
        force[i] += obstacle_force(belt, diameter[i], mass[i], position[i], velocity[i])
    return force


def belt_force(
    belt: Belt,
    diameter: float,
    mass: float,
    position: np.ndarray,
    velocity: np.ndarray,
    time: float,
) -> np.ndarray:
    """Force (2, N) of the belt on one bead: a disk of diameter <d> straight below the bead.

    It moves with the belt whatever its mass, which counts with the reduced mass alone.
    """
    place, motion = belt_motion(belt, time)
    centre = place[1] - (0.5 * belt.mean_diameter if belt.belt_ghost == "below" else 0.0)
    to_ghost = np.array([0.0, centre - position[1]])
    reach = 0.5 * (diameter + belt.mean_diameter)
    damped, _ = damping_masses(belt, mass, belt.ghost_mass)
    return contact_force(belt, to_ghost, velocity - motion, reach, damped)


def obstacle_force(
    belt: Belt, diameter: float, mass: float, position: np.ndarray, velocity: np.ndarray
) -> np.ndarray:
    """Force (2, N) on one bead of the heavy disk fixed at (L/2, A_z)."""
    if belt.obstacle == 0.0:
        return np.zeros(2)
    centre = np.array([0.5 * belt.width, belt.amplitude[1]])
    to_obstacle = nearest_image(centre - position, belt.width)
    reach = 0.5 * (diameter + belt.obstacle)
    return contact_force(belt, to_obstacle, velocity, reach, mass)


def nearest_image(separation: np.ndarray, width: float) -> np.ndarray:
    """Separations (..., 2) brought to the nearest periodic image in x."""
    return separation - np.round(separation / width) * np.array([width, 0.0])


# The two integrators for x'' = a(x, v, t), one step at a time.
#
# Gear predictor-corrector: Allen and Tildesley, Computer Simulation of Liquids (1987), four to six
# values, coefficients for second-order equations whose acceleration depends on the velocity.

Acceleration = Callable[[np.ndarray, np.ndarray, float], np.ndarray]

#: By the order, one less than the number of values.
GEAR_COEFFICIENTS = {
    3: (1 / 6, 5 / 6, 1.0, 1 / 3),
    4: (19 / 90, 3 / 4, 1.0, 1 / 2, 1 / 12),
    5: (3 / 16, 251 / 360, 1.0, 11 / 18, 1 / 6, 1 / 60),
}


def gear_start(
    acceleration: Acceleration,
    position: np.ndarray,
    velocity: np.ndarray,
    time: float,
    time_step: float,
    gear_order: int = 5,
) -> np.ndarray:
    """Scaled derivatives (order + 1, ...): row k is x^(k) dt^k/k!, zero above the second."""
    derivatives = [position, velocity, acceleration(position, velocity, time)]
    scaled = np.zeros((gear_order + 1, *np.shape(position)))
    for order, derivative in enumerate(derivatives):
        scaled[order] = derivative * time_step**order / factorial(order)
    return scaled


def gear_step(
    acceleration: Acceleration,
    scaled: np.ndarray,
    time: float,
    time_step: float,
    corrections: int = 1,
) -> np.ndarray:
    """Scaled derivatives at time + time_step: predict, then evaluate and correct, maybe again."""
    values = np.zeros_like(scaled)
    for order in range(len(scaled)):
        for higher in range(order, len(scaled)):
            values[order] += comb(higher, order) * scaled[higher]
    coefficients = GEAR_COEFFICIENTS[len(scaled) - 1]
    for _ in range(corrections):
        found = acceleration(values[0], values[1] / time_step, time + time_step)
        error = 0.5 * time_step**2 * found - values[2]
        values = np.array([row + c * error for row, c in zip(values, coefficients, strict=True)])
    return values


def verlet_step(
    acceleration: Acceleration,
    state: tuple[np.ndarray, np.ndarray, np.ndarray],
    time: float,
    time_step: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration at time + time_step from those at time.

    The acceleration is evaluated once, at the new position and a velocity predicted by v + a dt.
    """
    position, velocity, old = state
    position = position + velocity * time_step + 0.5 * old * time_step**2
    new = acceleration(position, velocity + old * time_step, time + time_step)
    return position, velocity + 0.5 * time_step * (old + new), new


class Beads(NamedTuple):
    """Diameters (N,) m, masses (N,) kg, positions (N, 2) m and velocities (N, 2) m/s."""

    diameter: np.ndarray
    mass: np.ndarray
    position: np.ndarray
    velocity: np.ndarray


class Scheme(NamedTuple):
    """Integrator "gear", of an order and with corrections per step, or "verlet"; its step (s)."""

    time_step: float
    integrator: str = "gear"
    order: int = 5
    corrections: int = 1


def run(belt: Belt, beads: Beads, scheme: Scheme, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (steps + 1, N, 2) and velocities of a run that begins at time 0.

    The first row is the initial state; positions are not wrapped.
    """
    position, velocity, time_step = beads.position, beads.velocity, scheme.time_step

    def acceleration(x: np.ndarray, v: np.ndarray, t: float) -> np.ndarray:
        weight = np.array([0.0, -belt.gravity])
        force = forces(belt, beads.diameter, beads.mass, x, v, t)
        return force / beads.mass[:, None] + weight

    positions, velocities = [position], [velocity]
    times = time_step * np.arange(steps)
    if scheme.integrator == "gear":
        scaled = gear_start(acceleration, position, velocity, 0.0, time_step, scheme.order)
        for time in times:
            scaled = gear_step(acceleration, scaled, time, time_step, scheme.corrections)
            positions.append(scaled[0])
            velocities.append(scaled[1] / time_step)
    else:
        state = (position, velocity, acceleration(position, velocity, 0.0))
        for time in times:
            state = verlet_step(acceleration, state, time, time_step)
            positions.append(state[0])
            velocities.append(state[1])
    return np.array(positions), np.array(velocities)
