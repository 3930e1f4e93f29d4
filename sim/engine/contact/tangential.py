"""What frictional laws share: the direction of the old friction, and the work done against it."""

from sim.engine.compile import inlined
from sim.engine.contact.roots import SMALLEST, inverse_square_root


@inlined
def friction_direction(normal, tangential):
    """Return the direction of the old friction within the present tangent plane.

    It is the zero vector for a friction of zero: all displacement then counts as new.
    """
    nx, ny, nz = normal
    tx, ty, tz = tangential
    along = nx * tx + ny * ty + nz * tz
    px, py, pz = tx - along * nx, ty - along * ny, tz - along * nz
    projected = px * px + py * py + pz * pz
    scale = inverse_square_root(projected) if projected > SMALLEST else 0.0
    return px * scale, py * scale, pz * scale


@inlined
def work_against(before, after, slip):
    """Return the work (J) done against a friction (N) that changes during a slip (m).

    The mean of both forces makes it the very change of the particles' kinetic energy: leap-frog
    lets the force of a step act with half of the displacement before it and half of that behind.
    """
    return 0.5 * (
        (before[0] + after[0]) * slip[0]
        + (before[1] + after[1]) * slip[1]
        + (before[2] + after[2]) * slip[2]
    )
