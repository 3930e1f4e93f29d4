"""The slow, readable reference: one contact between two spheres or between a sphere and a plane.

It is written from the papers alone and shares no code with the package that it checks, so an
agreement of the two is evidence. So are chute, belt and Hertzian impacts beside it.

Walton, Numerical simulation of inclined chute flows (1993), section 2: normal force 2.1,
tangential force 2.2 and equation 1.

``k_hat`` points from particle i to particle j (for a plane: from the sphere into the plane). The
force on i is ``-F_N k_hat + T``, the force on j the opposite. ``slip`` is the displacement during
the last step of the surface of j relative to that of i, so T on i points along a fresh slip.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import brentq

ROUNDING = 1e-12
"""A T this close to mu F_N, relative to it, counts as full sliding.

Equation 1 is singular there: the exponent 1/3 turns a rounding error of 1e-16 into a stiffness of
5e-6 K0, and with T* = T = mu F_N the bracket is 1 - 0/0.
"""


@dataclass(frozen=True)
class ContactLaw:
    """Parameters of the contact: stiffness K1 in N/m, the rest dimensionless.

    overlap_memory says what becomes of the largest overlap while the surfaces still overlap
    without force: it is kept until they part ("separation"), falls with the overlap ("shrink") or
    is forgotten ("reset"). friction_cap says whether T is cut to the friction limit "before" the
    tangential stiffness is evaluated, or only "after" the displacement has been added.
    sliding_direction says whether what is cut to the limit is the "printed" sum of steps 5 and 6 or
    the old force and K0 times the whole displacement ("slip").
    """

    stiffness: float
    restitution: float
    friction: float
    tangential_ratio: float = 0.8
    tangential_exponent: float = 1.0 / 3.0
    overlap_memory: str = "separation"
    friction_cap: str = "before"
    sliding_direction: str = "printed"

    @property
    def unloading_stiffness(self) -> float:
        """K2 in N/m, from e = sqrt(K1/K2)."""
        return self.stiffness / self.restitution**2

    @property
    def tangential_stiffness(self) -> float:
        """K0 in N/m."""
        return self.tangential_ratio * self.stiffness

    def update(
        self, contact: "Contact", overlap: float, k_hat: np.ndarray, slip: np.ndarray, *_
    ) -> tuple[float, np.ndarray, "Contact"]:
        """Advance a contact by one step, as `update`."""
        return update(contact, overlap, k_hat, slip, self)


@dataclass(frozen=True)
class Contact:
    """What a contact remembers from one step to the next; the defaults are a new contact.

    tangential_force is the vector T on particle i (3, N), turning_point the scalar T* (N), sense
    the sign of the last change of T, largest_overlap alpha_max (m), normal_force F_N (N), spring
    the part of T (3, N) that is no drag.
    """

    tangential_force: np.ndarray = field(default_factory=lambda: np.zeros(3))
    turning_point: float = 0.0
    sense: int = 1
    largest_overlap: float = 0.0
    normal_force: float = 0.0
    spring: np.ndarray = field(default_factory=lambda: np.zeros(3))

    #: Of laws that are plain functions: own numbers, rolling and twisting torque, their sum (N m).
    numbers: tuple[float, ...] = ()
    resistance: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    torque: np.ndarray = field(default_factory=lambda: np.zeros(3))


def update(
    contact: Contact, overlap: float, k_hat: np.ndarray, slip: np.ndarray, law: ContactLaw
) -> tuple[float, np.ndarray, Contact]:
    """Advance a contact by one step: normal force (N), T on particle i (3, N), new state.

    overlap is alpha (m), k_hat the unit normal (3), slip the surface displacement of the step
    (3, m), of which only the tangential part counts.
    """
    if overlap <= 0.0:
        return 0.0, np.zeros(3), Contact()
    normal_force, largest_overlap = normal(contact.largest_overlap, overlap, law)
    if normal_force == 0.0:
        return 0.0, np.zeros(3), Contact(largest_overlap=largest_overlap)
    state = tangential(contact, normal_force, k_hat, slip, law)
    state = replace(state, largest_overlap=largest_overlap)
    return normal_force, state.tangential_force, state


def normal(largest_overlap: float, overlap: float, law: ContactLaw) -> tuple[float, float]:
    """Normal force (N) and the largest overlap (m) to remember, for an overlap > 0."""
    k1, k2 = law.stiffness, law.unloading_stiffness
    largest_overlap = max(largest_overlap, overlap)
    rest_overlap = (1.0 - k1 / k2) * largest_overlap
    force = max(0.0, min(k1 * overlap, k2 * (overlap - rest_overlap)))
    if law.overlap_memory == "shrink" and overlap < rest_overlap:
        largest_overlap = overlap / (1.0 - k1 / k2)
    elif law.overlap_memory == "reset" and force == 0.0:
        largest_overlap = 0.0
    return force, largest_overlap


def tangential(
    contact: Contact, normal_force: float, k_hat: np.ndarray, slip: np.ndarray, law: ContactLaw
) -> Contact:
    """The six steps for T, T* and the sense, for a normal force > 0 (N)."""
    limit = law.friction * normal_force
    sense, k0 = contact.sense, law.tangential_stiffness

    # 1. The old force, turned into the present tangent plane with its magnitude.
    t_hat = unit(across(contact.tangential_force, k_hat))
    magnitude = length(contact.tangential_force) if t_hat.any() else 0.0
    if law.friction_cap == "before":
        magnitude = min(magnitude, limit)

    # 2. The turning point follows the normal force.
    turning_point = 0.0
    if contact.normal_force > 0.0:
        turning_point = contact.turning_point * normal_force / contact.normal_force

    # 3. Displacement along and across the old force.
    slip = across(slip, k_hat)
    along = float(np.dot(slip, t_hat))
    sideways = slip - along * t_hat

    # 4. Stiffness, with a new turning point wherever the sense changes.
    new_sense = sense if along == 0.0 else int(np.sign(along))
    if new_sense != sense:
        turning_point = magnitude
    stiffness = k0 * softening(magnitude, turning_point, new_sense, limit, law)

    # 5. Along the old force, which may turn round.
    parallel = magnitude + stiffness * along
    if along < 0.0 and parallel < 0.0:
        turning_point, new_sense = -turning_point, 1

    # 6. Across it every displacement is new.
    force = parallel * t_hat + k0 * sideways
    if law.sliding_direction == "slip" and length(force) > limit:
        force = magnitude * t_hat + k0 * slip
    force = shortened(force, limit)
    return Contact(force, turning_point, new_sense, contact.largest_overlap, normal_force)


def softening(
    magnitude: float, turning_point: float, sense: int, limit: float, law: ContactLaw
) -> float:
    """K_T/K0 of equation 1, in [0, 1]; 1 for a zero exponent.

    Each bracket of equation 1 is the distance of T to the end of its branch over that of T*:
    1 - (T - T*)/(mu F_N - T*) = (mu F_N - T)/(mu F_N - T*). The denominator comes last because a
    T* that was set at full sliding stays at mu F_N, up to rounding of either sign; a T below such
    a T* has not slid since the turning point and keeps K0.
    """
    if sense > 0:
        left, available = limit - magnitude, limit - turning_point
    else:
        left, available = limit + magnitude, limit + turning_point
    if left <= ROUNDING * limit:
        base = 0.0
    elif left >= available:
        base = 1.0
    else:
        base = left / available
    return base**law.tangential_exponent


def across(vector: np.ndarray, k_hat: np.ndarray) -> np.ndarray:
    """The part of a vector in the plane across k_hat."""
    return vector - k_hat * np.dot(k_hat, vector)


def unit(vector: np.ndarray) -> np.ndarray:
    """The vector scaled to length 1; zero stays zero."""
    size = length(vector)
    return vector / size if size > 0.0 else np.zeros(3)


def shortened(vector: np.ndarray, limit: float) -> np.ndarray:
    """The vector, scaled back to the length limit if it is longer."""
    size = length(vector)
    return vector * (limit / size) if size > limit else vector


def length(vector: np.ndarray) -> float:
    """Euclidean length."""
    return float(np.sqrt(np.dot(vector, vector)))


# Linear springs, a dashpot along the normal and a friction limit: Cundall and Strack, Géotechnique
# 29 (1979) 47. Interface and signs are those above.


@dataclass(frozen=True)
class SpringDashpotLaw:
    """Stiffness (N/m), restitution, friction, reduced mass (kg), time step (s), K_t/K.

    The mass is that of all partners, or 0: each pair then has its own. A normal force that would
    pull is kept, or clipped at 0: see `sim.parameters.dashpot`. The normal drag is gamma_n m v_n
    (normal_damping, 1/s), or where that is 0 the one that gives the restitution; along the surfaces
    it is gamma_t m v_t (tangential_damping, 1/s). A spring that is turned into the new tangent
    plane keeps its length, or only its part in that plane (projected), as another engine has it.
    """

    stiffness: float
    restitution: float
    friction: float
    mass: float
    time_step: float
    tangential_ratio: float = 0.8
    attraction: str = "kept"
    normal_damping: float = 0.0
    tangential_damping: float = 0.0
    projected: bool = False

    @property
    def damping(self) -> float:
        """Coefficient c (kg/s) of the damped oscillator that gives the restitution."""
        if self.normal_damping:
            return self.normal_damping * self.mass
        rate, critical = -np.log(self.restitution), 2 * np.sqrt(self.stiffness * self.mass)
        if self.attraction == "kept":
            return critical * rate / np.sqrt(np.pi**2 + rate**2)
        return critical * np.cos(brentq(lambda angle: 2 * angle / np.tan(angle) - rate, 1e-6, 1.57))

    def update(
        self, contact: Contact, overlap: float, k_hat: np.ndarray, slip: np.ndarray, *partners
    ) -> tuple[float, np.ndarray, Contact]:
        """Advance a contact by one step: normal force (N), T on particle i (3, N), new state.

        The last of partners is their reduced mass (kg).
        """
        if not self.mass:
            return replace(self, mass=partners[-1]).update(contact, overlap, k_hat, slip)
        closing = -float(slip @ k_hat) / self.time_step
        normal_force = self.stiffness * overlap + self.damping * closing
        if self.attraction == "clipped":
            normal_force = max(normal_force, 0.0)
        slip = across(slip, k_hat)
        spring = (across if self.projected else turned)(contact.spring, k_hat)
        spring = spring + self.tangential_ratio * self.stiffness * slip
        drag = self.tangential_damping * self.mass * slip / self.time_step
        force = shortened(spring + drag, self.friction * abs(normal_force))
        # The sum is cut, and the spring is what is left of it beside the drag.
        return normal_force, force, Contact(force, normal_force=normal_force, spring=force - drag)


@dataclass(frozen=True)
class FunctionLaw:
    """A law that is a plain function, `sim.parameters.laws.law`: its numbers, how many vectors are
    among the numbers it remembers, whether it rolls, how far (m) beyond contact it reaches."""

    law: tuple
    force: Callable
    vectors: int
    remembers: int
    rolls: bool
    reach: float

    @classmethod
    def of(cls, point, numbers: tuple) -> "FunctionLaw":
        """The law of a point of the package, with the numbers that it makes of one."""
        option = point.option("law")
        force, remembers, vectors = option.of(type(numbers))
        return cls(numbers, force, vectors, remembers, option.rolls, point.law_reach)

    def update(
        self,
        contact: Contact,
        overlap: float,
        k_hat: np.ndarray,
        slip: np.ndarray,
        turn: np.ndarray,
        radius: float,
        mass: float,
    ) -> tuple[float, np.ndarray, Contact]:
        """Advance a contact by one step: normal force (N), T on particle i (3, N), new state.

        turn is by what j has turned relative to i in the step (3, rad); radius (m) and mass (kg)
        are the reduced ones.
        """
        numbers = contact.numbers or (0.0,) * self.remembers
        ends = range(0, 3 * self.vectors, 3)
        vectors = [number for k in ends for number in turned(numbers[k : k + 3], k_hat)]
        rolling = (*across(turn, k_hat), turn @ k_hat)
        held = (*turned(contact.resistance[:3], k_hat), contact.resistance[3])
        normal_force, shear, numbers, _, *torque = self.force(
            self.law,
            overlap,
            -float(slip @ k_hat),
            tuple(across(slip, k_hat)),
            tuple(turned(contact.tangential_force, k_hat)),
            (*vectors, *numbers[3 * self.vectors :]),
            radius,
            mass,
            *((rolling, held) if self.rolls else ()),
        )
        resistance = torque[0] if torque else contact.resistance
        total = np.array(resistance[:3]) + resistance[3] * k_hat
        new = Contact(np.array(shear), normal_force=normal_force, numbers=numbers, torque=total)
        return normal_force, np.array(shear), replace(new, resistance=resistance)


def turned(vector: Sequence[float], k_hat: np.ndarray) -> np.ndarray:
    """A vector turned into the plane across k_hat, with its length."""
    return unit(across(np.array(vector), k_hat)) * length(np.array(vector))
