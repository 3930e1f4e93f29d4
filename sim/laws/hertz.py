"""Hertz's normal force, Mindlin's tangential stiffness, a dashpot with a constant restitution.

With the normal stiffness S = 2 E* √(R* α): F_N = (2/3) S α + 2 √(5/6) β √(S m*) dα/dt. With
β = -ln e/√(π² + ln² e) the restitution is e at every velocity and size (Tsuji, Tanaka and
Ishida, Powder Technol. 71 (1992) 239). The tangential stiffness is a constant share of S, 2(1 - ν)
/(2 - ν) of spheres with Poisson's ratio ν (Mindlin, J. Appl. Mech. 16 (1949) 259), and its force is
cut to μ |F_N|. A force that is kept while the contact unloads stretches its softening spring
without work. So an option lets it fall with the stiffness: the spring then keeps its length.
Loading stiffens the spring at its force, which shortens it. Either way work is lost, never gained.
Another option clips a normal force that pulls.
"""

from math import sqrt
from typing import Any, NamedTuple

from sim.parameters.dashpot import damping_fraction
from sim.parameters.laws import SMALL_OVERLAP, law
from sim.parameters.spheres import SphereParameters

#: Velocity in √(gσ) of the impacts that the time step must resolve.
IMPACT = 10


class Hertz(NamedTuple):
    """``modulus`` E* (Pa); ``tangential`` stiffness relative to the normal one; ``damping``
    2 √(5/6) β over the time step (1/s); ``friction`` μ."""

    modulus: float
    tangential: float
    damping: float
    friction: float


class HertzVariant(NamedTuple):
    """The same numbers, and those of the options: 1 where the normal force ``clips`` its pull, and
    where the tangential force ``falls`` with its stiffness, else 0."""

    modulus: float
    tangential: float
    damping: float
    friction: float
    clips: float
    falls: float


def effective_modulus(p: SphereParameters) -> float:
    """Return E*, Pa: at an overlap of σ/100 the force equals that of the spring K1."""
    return 15 * p.normal_stiffness / p.diameter


def collision_time(p: SphereParameters) -> float:
    """Return 2.87 (m*²/(R* E*² v))^(1/5) of the lightest particles at v = 10 √(gσ), s."""
    radius = p.diameter * (1 - p.diameter_spread) / 4
    speed = IMPACT * p.velocity_unit
    return 2.87 * ((p.lightest_mass / 2 / effective_modulus(p)) ** 2 / (radius * speed)) ** 0.2


def make(p: SphereParameters, partners: Any) -> Hertz | HertzVariant:
    """Return the law of a point for one kind of partners; plane and spheres are of one material."""
    share, whole = damping_fraction(p.restitution, p.attraction)
    damping = 2.0 * sqrt(5.0 / 6.0) * share / whole
    usual = Hertz(
        effective_modulus(p),
        float(p.tangential_share),
        damping / partners.time_step,
        float(partners.friction),
    )
    clips, falls = p.attraction == "clipped", p.tangential_unloading == "rescaled"
    return HertzVariant(*usual, float(clips), float(falls)) if clips or falls else usual


def force(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return normal and tangential force, the drag to remember and the loss, as `law` defines them.

    See `sim.parameters.laws.law`.
    """
    stiffness = 2.0 * law.modulus * sqrt(radius * max(overlap, 0.0))
    drag = law.damping * sqrt(stiffness * mass) * approach
    normal = 2.0 / 3.0 * stiffness * overlap + drag
    spring = law.tangential * stiffness
    tx = tangential[0] + spring * slip[0]
    ty = tangential[1] + spring * slip[1]
    tz = tangential[2] + spring * slip[2]
    size = sqrt(tx * tx + ty * ty + tz * tz)
    limit = law.friction * abs(normal)
    scale = limit / size if size > limit else 1.0
    loss = 0.5 * (memory[0] + drag) * approach
    return normal, (tx * scale, ty * scale, tz * scale), (drag,), loss


def variant_force(law, overlap, approach, slip, tangential, memory, radius, mass):
    """Return what `force` does, with the options of the law; it also remembers the stiffness."""
    stiffness = 2.0 * law.modulus * sqrt(radius * max(overlap, 0.0))
    share = 1.0 - law.falls * (1.0 - stiffness / memory[1]) if stiffness < memory[1] else 1.0
    held = (tangential[0] * share, tangential[1] * share, tangential[2] * share)
    normal, (tx, ty, tz), (drag,), loss = force(
        law, overlap, approach, slip, held, memory, radius, mass
    )
    pull = law.clips * min(normal, 0.0)
    rubs = 0.0 if pull < 0.0 else 1.0
    along = (tx * rubs, ty * rubs, tz * rubs)
    return normal - pull, along, (drag - pull, stiffness), loss - 0.5 * pull * approach


def energy(law, overlap, tangential, memory, radius, mass):
    """Return the energy (J) in the normal and in the tangential spring."""
    stiffness = 2.0 * law.modulus * sqrt(radius * max(overlap, 0.0))
    square = tangential[0] ** 2 + tangential[1] ** 2 + tangential[2] ** 2
    spring = law.tangential * stiffness
    normal = 4.0 / 15.0 * stiffness * overlap * overlap
    return normal, 0.5 * square / spring if spring > 0.0 else 0.0


law(
    "hertz",
    description="Hertz's and Mindlin's, at an overlap of σ/100 as stiff as the spring K1",
    make=make,
    force=force,
    energy=energy,
    collision_time=collision_time,
    remembers=1,
    max_overlap=SMALL_OVERLAP,
    owns=("attraction", "tangential_unloading", "youngs_modulus", "poisson_ratio"),
    replaces={"youngs_modulus": ("stiffness", "tangential_ratio")},
    variants={HertzVariant: (variant_force, 2)},
)
