"""A column of equal beads on the belt: the simplest model that explains Gallas' onset.

Beads on top of each other, one in each layer of the bed, feel their neighbours and the belt as in
the engine: a linear spring, damping along the line of centres, shear friction across it. There is
nothing else: no disorder, no neighbours at the side. `python -m benchmarks.column` prints the
transport of the column relative to the velocity amplitude of the belt, V_x/(A_x 2πf).
"""

from math import pi, radians, tan
from typing import NamedTuple

import numba
import numpy as np

#: Frequencies (Hz), amplitudes (⟨d⟩) and stiffnesses (g⟨m⟩/⟨d⟩) of the table.
FREQUENCIES = (10, 12, 13, 14, 15, 16, 17, 18, 20, 22, 25, 30, 40, 60, 80, 100)
CASES = ((1.0, 1e3), (0.5, 1e3), (1.5, 1e3), (1.0, 500.0), (1.0, 2e3), (1.0, 5e3))

#: Gravity in ⟨d⟩/s² for ⟨d⟩ = 1 mm, as in the paper.
GRAVITY = 1e4

#: How long a column is shaken, in cycles, and the time steps of a cycle.
CYCLES, STEPS = 90, 4000


class Column(NamedTuple):
    """Beads and their contacts, by the names and in the units of the engine's parameters."""

    stiffness: float = 1000.0
    damping: float = 50.0
    shear_damping: float = 50.0
    beads: int = 10


BED = Column()


def transport(
    frequency: float, amplitude: float = 1.0, angle: float = 45.0, column: Column = BED
) -> float:
    """Return V_x/(A_x 2πf) of a column over cycles 46 to 90; parameters as in the engine."""
    start = _settled(column.beads, column.stiffness)
    return _shake(start, frequency, amplitude, tan(radians(angle)), column)


def _settled(beads: int, stiffness: float) -> np.ndarray:
    """Return the heights (⟨d⟩) of beads at rest, each contact compressed by the weight above it."""
    carried = np.arange(beads, 0, -1) / stiffness
    return np.arange(beads) + 0.5 - np.cumsum(carried)


@numba.njit
def _shake(start, frequency, amplitude, slope, column):
    """Integrate a column (masses 1, lengths ⟨d⟩) with symplectic Euler steps."""
    spring = column.stiffness * GRAVITY
    damping, shear = 10.0 * column.damping, 10.0 * column.shear_damping
    z, vz, vx = start.copy(), np.zeros_like(start), np.zeros_like(start)
    rate, dt, carried = 2 * pi * frequency, 1 / (frequency * STEPS), 0.0
    for step in range(1, CYCLES * STEPS + 1):
        phase = rate * step * dt
        below, rise = amplitude * np.sin(phase) - 0.5, amplitude * rate * np.cos(phase)
        drift = rise / slope
        push = pull = 0.0
        for i in range(z.size):
            overlap, closing, slip = 1 - (z[i] - below), vz[i] - rise, vx[i] - drift
            force = spring * overlap - damping * closing if overlap > 0 else 0.0
            drag = -shear * slip if overlap > 0 else 0.0
            below, rise, drift = z[i], vz[i], vx[i]
            if i > 0:
                vz[i - 1] += (push - force - GRAVITY) * dt
                vx[i - 1] += (pull - drag) * dt
            push, pull = force, drag
        vz[-1] += (push - GRAVITY) * dt
        vx[-1] += pull * dt
        z += vz * dt
        if step > CYCLES * STEPS // 2:
            carried += vx.mean()
    return carried / (CYCLES * STEPS - CYCLES * STEPS // 2) / (amplitude * rate / slope)


def main() -> None:
    """Print the table."""
    heads = [f"A_z {amplitude:g}, Y {stiffness:g}" for amplitude, stiffness in CASES]
    print("  ".join(["f (Hz)", *heads]))
    for frequency in FREQUENCIES:
        values = [transport(frequency, a, column=Column(y)) for a, y in CASES]
        cells = [f"{value:{len(head)}.3f}" for value, head in zip(values, heads, strict=True)]
        print("  ".join([f"{frequency:6g}", *cells]))


if __name__ == "__main__":
    main()
