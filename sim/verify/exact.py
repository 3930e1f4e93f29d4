"""Exact solutions of the tests: closed forms, and equations solved without the engine."""

from math import acos, exp, log, pi, sqrt

import numpy as np
from scipy.optimize import brentq

#: Change of a rim's velocity per change of velocity by the same force: solid spheres.
RIM = 2.5

#: Duration of an elastic impact after Hertz, in units of the largest overlap over the speed.
LASTING = 2.94327


def hertz_impact(mass: float, modulus: float, radius: float, speed: float) -> dict[str, float]:
    """Return largest overlap (m), largest force (N) and duration (s) of an elastic impact.

    ``modulus`` E* in Pa; reduced ``mass`` (kg) and ``radius`` (m).
    """
    overlap = (15 / 16 * mass * speed**2 / (modulus * sqrt(radius))) ** 0.4
    force = 4 / 3 * modulus * sqrt(radius) * overlap**1.5
    return {"overlap": overlap, "force": force, "duration": LASTING * overlap / speed}


def pull_of_dashpot(restitution: float) -> float:
    """Return the share by which a dashpot that pulls makes friction exceed μ (1 + e) m v_n.

    It is 2 (e_c - e)/(1 + e), with the restitution e_c where the force of this damping is clipped.
    """
    lost = -log(restitution)
    ratio = lost / sqrt(pi**2 + lost**2)
    clipped = exp(-2 * ratio * acos(ratio) / sqrt(1 - ratio**2))
    return 2 * (clipped - restitution) / (1 + restitution)


def mindlin_rebound(
    share: float, friction: float, slopes: np.ndarray, springs: int = 400, steps: int = 4000
) -> np.ndarray:
    """Return the surface velocities after elastic impacts on a plane, with micro-slip (slopes,).

    They and ``slopes``, those before, are relative to the normal velocity; ``share`` is the
    tangential stiffness over the normal one. Cattaneo's and Mindlin's contact, each place of which
    sticks or slips for itself, along any history of both forces: what Maw, Barber and Fawcett (Wear
    38 (1976) 101) have solved for impacts. It is that of independent springs along a line (Popov
    and Heß, Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer 2015).
    """
    deepest = (15 / 16) ** 0.4
    width = sqrt(deepest) / springs
    place = (np.arange(springs) + 0.5) * width
    step = LASTING * deepest / steps
    overlap, approach, slip = 0.0, 1.0, np.array(slopes, float)
    pulled = np.zeros((len(slip), springs))
    while overlap >= 0.0:
        pressed = np.maximum(overlap - place**2, 0.0)
        pulled += share * slip[:, None] * step
        pulled = np.clip(pulled, -friction * pressed, friction * pressed)
        approach -= 4 / 3 * overlap**1.5 * step
        slip = slip - (1 + RIM) * 2 * width * pulled.sum(axis=1) * step
        overlap += approach * step
    return slip


def bounces(
    number: int,
    height: float,
    radius: float,
    mass: float,
    stiffness: float,
    restitution: float,
    gravity: float,
) -> np.ndarray:
    """Return the heights (m) of the centre after bounces on a spring and dashpot."""
    lost = -log(restitution)
    natural = sqrt(stiffness / mass)
    damping = lost / sqrt(pi**2 + lost**2) * natural
    rate, rest, found = sqrt(natural**2 - damping**2), gravity / natural**2, []
    decay = complex(-damping, rate)

    def place(time: float, swing: complex) -> float:
        return float((swing * np.exp(decay * time)).real - rest)

    for _ in range(number):
        speed = sqrt(2 * gravity * (height - radius))
        swing = complex(rest, (speed - damping * rest) / rate)
        end = brentq(place, 0.5 * pi / rate, 1.5 * pi / rate, args=(swing,))
        leaving = (swing * decay * np.exp(decay * end)).real
        height = radius + leaving**2 / (2 * gravity)
        found.append(height)
    return np.array(found)


def block_on_plane(plane: np.ndarray, gains: np.ndarray, cycles: int) -> np.ndarray:
    """Return the velocities in the last cycle of a block under Coulomb's friction.

    ``plane`` (n,) is the plane's velocity over a cycle, ``gains`` (n,) the most that friction
    changes the block's velocity by from the step before. It slides until it has the velocity of the
    plane, and goes with it where that takes no more (Winkler, Int. J. Mech. Sci. 20 (1978) 561).
    """
    velocity: float = 0.0
    last: list[float] = []
    for _ in range(cycles):
        last = []
        for goal, gain in zip(plane.tolist(), gains.tolist(), strict=True):
            velocity += min(max(goal - velocity, -gain), gain)
            last.append(velocity)
    return np.array(last)


def flight(strength: float) -> tuple[float, float]:
    """Return when a ball that does not bounce takes off from a plane, and its flight, in cycles.

    The plane shakes with ``strength`` times the acceleration of gravity: take-off at sin φ = 1/Γ.
    """
    start = np.arcsin(1 / strength)

    def above(time: float) -> float:
        ball = np.sin(start) + np.cos(start) * time - time**2 / (2 * strength)
        return float(ball - np.sin(start + time))

    return start / (2 * pi), brentq(above, 1e-2, 4 * pi) / (2 * pi)


def doubling(restitution: float) -> float:
    """Return the strength Γ at which the period of a bouncing ball doubles.

    Luck and Mehta, Phys. Rev. E 48 (1993) 3988.
    """
    e = restitution
    return float(np.hypot(pi * (1 - e) / (1 + e), 2 * (1 + e**2) / (1 + e) ** 2))


def ishigami(shares: np.ndarray) -> np.ndarray:
    """Return Ishigami and Homma's function, a = 7 and b = 0.1, at points (n, 3) of the cube."""
    x, y, z = (np.pi * (2 * shares - 1)).T
    return np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)


#: First-order indices of Ishigami's function, then total ones, in closed form.
_PARTS = 0.5 * (1 + 0.1 * pi**4 / 5) ** 2, 49 / 8, 0.01 * pi**8 * (1 / 18 - 1 / 50)
ISHIGAMI = np.array([_PARTS[0], _PARTS[1], 0.0, _PARTS[0] + _PARTS[2], _PARTS[1], _PARTS[2]])
ISHIGAMI /= sum(_PARTS)

#: Coefficients of Sobol's g-function; it has as many parameters as are asked for.
G = np.array([0.0, 1.0, 4.5, 9.0])


def g_function(shares: np.ndarray) -> np.ndarray:
    """Return Sobol's g-function, with a kink in the middle of each parameter, at points (n, d)."""
    own = G[: shares.shape[1]]
    return ((np.abs(4 * shares - 2) + own) / (1 + own)).prod(axis=1)


def g_indices(dimensions: int) -> np.ndarray:
    """Return first-order and total indices of the g-function, (2, d)."""
    parts = 1 / (3 * (1 + G[:dimensions]) ** 2)
    variance = np.prod(1 + parts) - 1
    return np.array([parts, parts * np.prod(1 + parts) / (1 + parts)]) / variance


#: Ranges of the borehole function: radii (m), transmissivities (m²/yr), heads (m), length (m) and
#: conductivity (m/yr), as Morris, Mitchell and Ylvisaker (Technometrics 35 (1993) 243) have them.
BOREHOLE = np.array(
    [
        *((0.05, 0.15), (100, 50_000), (63_070, 115_600), (990, 1110)),
        *((63.1, 116), (700, 820), (1120, 1680), (9855, 12_045)),
    ]
)


def borehole(shares: np.ndarray) -> np.ndarray:
    """Return the flow through a borehole (m³/yr) at points (n, 8) of the unit cube."""
    low, high = BOREHOLE.T
    own, far, upper, head, lower, other, length, speed = (low + shares * (high - low)).T
    ratio = np.log(far / own)
    leak = 2 * length * upper / (ratio * own**2 * speed)
    return 2 * pi * upper * (head - other) / (ratio * (1 + leak + upper / lower))
