"""Oblique impacts with Hertz's normal force, as differential equations: two ways to their friction.

Everything is relative to an impact's own units: the reduced mass, the normal velocity v of approach
and the length (m v²/(E* √R))^(2/5), so that E* √R is 1. Two spheres of any sizes, and a sphere on a
plane, are then one problem. ``bend`` is the unit of length over the distance of the centres, 0 for
a plane; ``slope`` the velocity of the surfaces across the normal over that along it.
"""

from math import acos, copysign, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

#: Change of a rim's velocity per change of velocity by the same force: solid spheres.
RIM = 2.5

#: Overlap with which a contact starts; the forces at none of it have no derivative.
START = 1e-12


#: Changes between sticking and slipping that no impact has but one at the edge of sliding.
CHANGES = 20


class Friction(NamedTuple):
    """Tangential stiffness over the normal one, friction coefficient, restitution above e⁻².

    Whether a normal force that would pull is 0, and whether friction falls with its stiffness.
    """

    share: float
    friction: float
    restitution: float = 1.0
    clipped: bool = False
    rescaled: bool = False

    @property
    def damping_ratio(self) -> float:
        """Damping over the critical one, in the plane of overlap^(5/4) and its rate."""
        lost = -log(self.restitution)
        if not self.clipped:
            return lost / sqrt(pi**2 + lost**2)
        return brentq(lambda z: 2 * z * acos(z) / sqrt(1 - z * z) - lost, 0.0, 1 - 1e-9)


class Contact:
    """The equations of a contact: overlap, its rate, velocity across, rims, turn and friction.

    ``pushes`` is 1 until the damping makes the normal force attractive, then -1.
    """

    def __init__(self, law: Friction, bend: float):
        self.law, self.bend, self.pushes = law, bend, 1.0
        self.drag = 2 * sqrt(5 / 6) * law.damping_ratio

    def normal(self, y) -> tuple[float, float]:
        """Return the normal force and the stiffness."""
        stiffness = 2 * sqrt(max(y[0], 0.0))
        return 2 / 3 * stiffness * y[0] + self.drag * sqrt(stiffness) * y[1], stiffness

    def limit(self, y) -> float:
        """Return the largest friction."""
        return self.law.friction * self.pushes * self.normal(y)[0]

    def rates(self, y, friction: float, growth: float) -> np.ndarray:
        """Return the rates under a friction, which grows at a rate."""
        overlap, approach, across = y[:3]
        turning = across * self.bend / (1 - overlap * self.bend)
        pressed = -self.normal(y)[0] - turning * across
        pulled = -friction + turning * approach
        return np.array([approach, pressed, pulled, RIM * friction, turning, growth])

    def stuck(self, _, y) -> np.ndarray:
        """Return the rates while the friction is that of Mindlin's spring."""
        spring = self.law.share * self.normal(y)[1] * (y[2] - y[3])
        return self.rates(y, y[5], spring + self.fall(y, y[5]))

    def fall(self, y, friction: float) -> float:
        """Return the rate at which a friction falls with its stiffness, as the overlap's root."""
        return 0.5 * friction * min(y[1], 0.0) / max(y[0], START) if self.law.rescaled else 0.0

    def slipping(self, sense: float):
        """Return the function of the rates while the friction is at its limit, along a sense."""
        return lambda _, y: self.rates(y, sense * self.limit(y), 0.0)

    def excess(self, y, sense: float) -> float:
        """Return how much faster than its limit a friction at it would grow along a sense."""
        stiffness, approach = self.normal(y)[1], y[1]
        pressed = self.rates(y, sense * self.limit(y), 0.0)[1]
        dragged = approach**2 / (4 * max(y[0], START)) + pressed
        growth = stiffness * approach + self.drag * sqrt(stiffness) * dragged
        spring = self.law.share * stiffness * (y[2] - y[3])
        spring = sense * spring + self.fall(y, self.limit(y))
        return spring - self.law.friction * self.pushes * growth


def rebound(law: Friction, slope: float, bend: float = 0.0) -> np.ndarray:
    """Return the velocities after an impact: of separation, across, of both rims; and the turn.

    The law ``hertz`` with vanishing time steps: a friction of Mindlin's stiffness, cut to its
    limit. Velocities are along the normal and the tangent of the end.
    """
    contact = Contact(law, bend)
    y = np.array([START, 1.0, slope, 0.0, 0.0, 0.0])
    sense = 1.0
    slips = contact.excess(y, sense) > 0
    for _ in range(CHANGES):
        if slips:
            changes = _event(lambda _, y, sense=sense: contact.excess(y, sense), -1)
            rates = contact.slipping(sense)
        else:
            changes = _event(lambda _, y: abs(y[5]) - contact.limit(y), 1)
            rates = contact.stuck
        pulls = _event(lambda _, y: contact.pushes * contact.normal(y)[0], -1)
        parts = _event(lambda _, y: y[0] - START, -1)
        events = [parts, changes, pulls]
        found = solve_ivp(rates, (0, 99), y, "DOP853", events=events, rtol=1e-9, atol=1e-12)
        y, (parted, _, pulled) = found.y[:, -1].copy(), found.t_events
        if parted.size or (pulled.size and law.clipped):
            # Without a force they part as they are, seen along where the normal is now.
            return np.array([-y[1], y[2], y[3], y[4]])
        if pulled.size:
            contact.pushes, sense = -1.0, copysign(1.0, y[2] - y[3])
            slips = contact.excess(y, sense) > 0
        else:
            sense = sense if slips else copysign(1.0, y[5])
            slips = not slips
        y[5] = sense * contact.limit(y)
    raise RuntimeError(f"sticks and slips by turns at slope {slope}")


def _event(function, direction: int):
    function.terminal, function.direction = True, direction
    return function
