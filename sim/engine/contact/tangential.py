"""Functions of all frictional laws: direction of the old friction, work done against friction."""

from sim.engine.compile import inlined
from sim.engine.contact.roots import SMALLEST, inverse_square_root


@inlined
def friction_direction(normal, tangential):
    """Return the direction of the old friction within the present tangent plane.

    A friction of zero has the zero vector: all displacement then counts as new.
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

    With the mean of both forces it is exactly the change of the particles' kinetic energy: in
    leap-frog the force of a step acts over half of the displacement before it and half of the next.
    """
    return 0.5 * (
        (before[0] + after[0]) * slip[0]
        + (before[1] + after[1]) * slip[1]
        + (before[2] + after[2]) * slip[2]
    )
