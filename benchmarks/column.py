"""A column of equal beads on the belt: the least model in which Gallas' onset can be understood.

Beads on top of each other, one in each layer of the bed, feel their neighbours and the belt as in
the engine: a linear spring, damping along the line of centres, shear friction across it. There is
nothing else: no disorder, no neighbours at the side. `python -m benchmarks.column` prints the
transport of the column relative to the velocity amplitude of the belt, V_x/(A_x 2πf).
"""

from math import pi, radians, tan

import numba
import numpy as np

#: Frequencies (Hz), amplitudes (⟨d⟩) and stiffnesses (g⟨m⟩/⟨d⟩) of the table.
FREQUENCIES = (10, 12, 13, 14, 15, 16, 17, 18, 20, 22, 25, 30, 40, 60, 80, 100)
CASES = ((1.0, 1000), (0.5, 1000), (1.5, 1000), (1.0, 500), (1.0, 2000), (1.0, 5000))

#: Gravity in ⟨d⟩/s² for ⟨d⟩ = 1 mm, as in the paper.
GRAVITY = 1e4


def transport(
    frequency: float,
    amplitude: float = 1.0,
    stiffness: float = 1000.0,
    angle: float = 45.0,
    damping: float = 50.0,
    shear_damping: float = 50.0,
    beads: int = 10,
) -> float:
    """Return V_x/(A_x 2πf) of a column over cycles 46 to 90; parameters as in the engine."""
    rates = (10.0 * damping, 10.0 * shear_damping)
    start = _settled(beads, stiffness)
    return _shake(start, frequency, amplitude, tan(radians(angle)), stiffness * GRAVITY, *rates)


def _settled(beads: int, stiffness: float) -> np.ndarray:
    """Return the heights (⟨d⟩) of beads at rest, each contact compressed by the weight above it."""
    carried = np.arange(beads, 0, -1) / stiffness
    return np.arange(beads) + 0.5 - np.cumsum(carried)


@numba.njit
def _shake(start, frequency, amplitude, slope, spring, damping, shear, cycles=90, steps=4000):
    """Integrate a column (masses 1, lengths ⟨d⟩) with symplectic Euler steps."""
    z, vz, vx = start.copy(), np.zeros_like(start), np.zeros_like(start)
    rate, dt, carried = 2 * pi * frequency, 1 / (frequency * steps), 0.0
    for step in range(1, cycles * steps + 1):
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
        if step > cycles * steps // 2:
            carried += vx.mean()
    return carried / (cycles * steps - cycles * steps // 2) / (amplitude * rate / slope)


def main() -> None:
    """Print the table."""
    heads = [f"A_z {amplitude:g}, Y {stiffness:g}" for amplitude, stiffness in CASES]
    print("  ".join(["f (Hz)", *heads]))
    for frequency in FREQUENCIES:
        values = [transport(frequency, *case) for case in CASES]
        cells = [f"{value:{len(head)}.3f}" for value, head in zip(values, heads, strict=True)]
        print("  ".join([f"{frequency:6g}", *cells]))


if __name__ == "__main__":
    main()
