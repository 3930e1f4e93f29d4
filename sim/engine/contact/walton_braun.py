"""Walton and Braun's contact: hysteretic normal spring, friction whose stiffness falls to zero.

Equations: Walton, Mech. Mater. 16 (1993) 239, section 2; docs/physics.md lists the misprint in the
surface displacement and the points that the paper leaves open.
"""

from typing import NamedTuple

from sim.engine.compile import by_type, implements, inlined
from sim.engine.contact.friction import (
    SMALLEST,
    contact_force,
    cube_root,
    declare_memory,
    friction_direction,
    inverse_square_root,
    stored_energy,
    work_against,
)

#: A friction this close to its limit, relative, is at it. Without the margin a friction just cut to
#: the limit would keep a stiffness made of its rounding error, which the cube root turns into 5e-6.
ROUNDING = 1e-12


class Linear(NamedTuple):
    """Exponent 0: the tangential spring of Cundall and Strack."""

    exponent: float = 0.0


class CubeRoot(NamedTuple):
    """Exponent 1/3: Mindlin's elastic spheres under a constant normal force."""

    exponent: float = 1.0 / 3.0


class Power(NamedTuple):
    """Any other exponent; 1 and 2 resemble plastic contacts."""

    exponent: float


class Separation(NamedTuple):
    """The largest overlap is remembered until the spheres separate."""

    slope: float


class Shrink(NamedTuple):
    """The dent recovers while the overlap is smaller than its depth."""

    slope: float


class Reset(NamedTuple):
    """The largest overlap is forgotten as soon as the normal force is zero."""

    slope: float


class CapBefore(NamedTuple):
    """A friction that exceeds the limit is cut before the stiffness is evaluated."""

    friction: float


class CapAfter(NamedTuple):
    """A friction that exceeds the limit is cut at the end of the step only."""

    friction: float


class AsPrinted(NamedTuple):
    """A friction cut to the limit has the direction of the sum that was cut."""

    settles: float = 0.0


class AlongSlip(NamedTuple):
    """A friction cut to the limit has the direction of the old force and K0 times all of the slip.

    Per unit of slip both readings turn the friction by K0 sin φ/(μ F_N), at its angle φ with the
    slip. But in the printed sum a sliding friction keeps its length along its old direction and
    grows across it. Where a step slips by more than 2 μ F_N/K0, that sum turns it from φ to φ - 90°
    and never settles.
    """

    settles: float = 1.0


class WaltonBraun(NamedTuple):
    """Parameters of the law; the types of the last four select its readings.

    Attributes: ``loading`` and ``unloading`` stiffness K1 and K2 = K1/e² (N/m), ``tangential``
    stiffness K0 (N/m); ``stiffening`` (Linear, CubeRoot or Power), ``dent`` (Separation, Shrink or
    Reset, holding 1 - K1/K2), ``limit`` (CapBefore or CapAfter, holding the coefficient μ) and
    ``sliding`` (AsPrinted or AlongSlip).
    """

    loading: float
    unloading: float
    tangential: float
    stiffening: Linear | CubeRoot | Power
    dent: Separation | Shrink | Reset
    limit: CapBefore | CapAfter
    sliding: AsPrinted | AlongSlip


#: Magnitude of the friction, its turning point, whether it falls, and the largest overlap.
declare_memory(WaltonBraun, 4, always_read=True)


def walton_braun(
    stiffness: float,
    restitution: float,
    friction: float,
    tangential_ratio: float = 0.8,
    tangential_exponent: float = 1.0 / 3.0,
    *,
    overlap_memory: str = "separation",
    friction_cap: str = "before",
    sliding_direction: str = "printed",
) -> WaltonBraun:
    """Return the law for K1 (N/m), e, μ, K0/K1, γ and the three readings."""
    special = {0.0: Linear(), round(1.0 / 3.0, 9): CubeRoot()}
    slope = 1.0 - restitution**2
    return WaltonBraun(
        loading=float(stiffness),
        unloading=stiffness / restitution**2,
        tangential=float(tangential_ratio * stiffness),
        stiffening=special.get(round(tangential_exponent, 9), Power(float(tangential_exponent))),
        dent={"separation": Separation, "shrink": Shrink, "reset": Reset}[overlap_memory](slope),
        limit={"before": CapBefore, "after": CapAfter}[friction_cap](float(friction)),
        sliding={"printed": AsPrinted, "slip": AlongSlip}[sliding_direction](),
    )


@by_type
def softening(kind, base):
    """Return base**γ for base in [0, 1], with 0**0 = 1 (the bracket of Eq. 1)."""
    if kind.instance_class is Linear:
        return lambda kind, base: 1.0
    if kind.instance_class is CubeRoot:
        return lambda kind, base: cube_root(base)
    return lambda kind, base: base**kind.exponent


@by_type
def dent_overlap(kind, overlap, overlap_max, normal_force):
    """Return the largest overlap to remember after a step."""
    if kind.instance_class is Separation:
        return lambda kind, overlap, overlap_max, normal_force: overlap_max
    if kind.instance_class is Shrink:
        return lambda kind, overlap, overlap_max, normal_force: (
            overlap / kind.slope if overlap < kind.slope * overlap_max else overlap_max
        )
    return lambda kind, overlap, overlap_max, normal_force: (
        overlap_max if normal_force > 0.0 else 0.0
    )


@by_type
def cap(kind, magnitude, limit):
    """Return the friction that enters the stiffness, cut to the limit or not."""
    if kind.instance_class is CapBefore:
        return lambda kind, magnitude, limit: min(magnitude, limit)
    return lambda kind, magnitude, limit: magnitude


@by_type
def direction_term(kind, change, before, direction, slip_force, limit):
    """Return the part (N) of the new friction along the old ``direction``, before it is cut.

    The other part is ``slip_force``, K0 times all of the slip. With ``change`` their sum is the
    printed one. `AlongSlip` takes the magnitude ``before`` of the old friction instead where the
    printed sum is beyond the limit.
    """
    if kind.instance_class is AsPrinted:
        return lambda kind, change, before, direction, slip_force, limit: change

    def body(kind, change, before, direction, slip_force, limit):
        x = change * direction[0] + slip_force[0]
        y = change * direction[1] + slip_force[1]
        z = change * direction[2] + slip_force[2]
        return before if x * x + y * y + z * z > limit * limit else change

    return body


@inlined
def normal_force(law, overlap, overlap_before):
    """Return the normal force and the largest overlap, from the overlap and its largest so far.

    F_N = max(0, min(K1 α, K2 (α - α0))) with α0 = (1 - K1/K2) α_max: loading along K1, unloading
    and reloading along K2.
    """
    overlap_max = max(overlap, overlap_before)
    rest = law.dent.slope * overlap_max
    force = max(0.0, min(law.loading * overlap, law.unloading * (overlap - rest)))
    return force, dent_overlap(law.dent, overlap, overlap_max, force)


@inlined
def hysteretic_loss(law, overlap, overlap_before):
    """Return the energy (J) lost while the largest overlap grows.

    Loading to α_max takes ½ K1 α_max², and unloading along K2 gives back e² = K1/K2 of it.
    """
    deepest = max(overlap, overlap_before)
    return 0.5 * law.loading * law.dent.slope * (deepest * deepest - overlap_before**2)


@inlined
def parallel_friction(law, force, magnitude, displacement, turning_point, falling):
    """Return friction along its old direction, turning point and sense (Eq. 1 and section 2.2).

    ``falling`` is 0 while the friction grows and 1 while it falls; when it changes, the friction
    becomes the new turning point. The turning point is stored as a share of the normal force,
    T*/F_N, with which T* scales. The bracket of Eq. 1 is the ``distance`` to sliding over that at
    the turning point. A negative result means that the friction has reversed: the turning point
    changes sign and, seen along the new direction, the friction grows.
    """
    friction = law.limit.friction
    share = magnitude / force if force > 0.0 else 0.0
    falling_now = 0.0 if displacement > 0.0 else (1.0 if displacement < 0.0 else falling)
    turning_point = turning_point if falling_now == falling else share
    sense = 1.0 - 2.0 * falling_now
    distance = friction - sense * share
    turning_distance = friction - sense * turning_point
    base = 1.0 if distance >= turning_distance else distance / turning_distance
    base = base if distance > ROUNDING * friction else 0.0
    parallel = magnitude + law.tangential * softening(law.stiffening, base) * displacement
    has_reversed = parallel < 0.0 and displacement < 0.0
    turning_point = -turning_point if has_reversed else turning_point
    return parallel, turning_point, 0.0 if has_reversed else falling_now


@implements(contact_force)
def _walton_braun(law, overlap, approach, normal, slip, memory):
    if law.instance_class is not WaltonBraun:
        return None

    def body(law, overlap, approach, normal, slip, memory):
        before, magnitude, turning_point, falling, overlap_max = memory[:3], *memory[3:]
        loss = hysteretic_loss(law, overlap, overlap_max)
        force, overlap_max = normal_force(law, overlap, overlap_max)
        limit = law.limit.friction * force

        ux, uy, uz = friction_direction(normal, before)
        magnitude = cap(law.limit, magnitude, limit)
        sx, sy, sz = slip
        along = sx * ux + sy * uy + sz * uz
        parallel, turning_point, falling = parallel_friction(
            law, force, magnitude, along, turning_point, falling
        )
        change = parallel - law.tangential * along
        slip_force = law.tangential * sx, law.tangential * sy, law.tangential * sz
        change = direction_term(law.sliding, change, magnitude, (ux, uy, uz), slip_force, limit)
        tx = change * ux + law.tangential * sx
        ty = change * uy + law.tangential * sy
        tz = change * uz + law.tangential * sz

        square = tx * tx + ty * ty + tz * tz
        inverse = inverse_square_root(square) if square > SMALLEST else 0.0
        magnitude = min(square * inverse, limit)
        scale = magnitude * inverse
        tangential = (tx * scale, ty * scale, tz * scale)
        is_pressed = force > 0.0
        turning_point = turning_point if is_pressed else 0.0
        falling = falling if is_pressed else 0.0
        return (
            force,
            tangential,
            (*tangential, magnitude, turning_point, falling, overlap_max),
            (loss, work_against(before, tangential, slip)),
        )

    return body


@implements(stored_energy)
def _stored_energy(law, overlap, memory):
    if law.instance_class is not WaltonBraun:
        return None

    def body(law, overlap, memory):
        force, _ = normal_force(law, overlap, memory[6])
        return 0.5 * force * force / law.unloading, 0.5 * memory[3] * memory[3] / law.tangential

    return body
