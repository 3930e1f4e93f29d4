"""How long a neighbor list holds: displacements measured against the mean flow.

A pair that is not in the list can come into contact only when its partners approach each other. The
common motion of all particles brings none together, and a flow whose velocity changes with height
brings pairs together only as fast as the steepest slope of its profile shears them. What counts is
how far particles stray from that flow, so that the list of a fast flow lives several times longer.
"""

from math import sqrt

import numpy as np

from sim.engine.compile import inlined
from sim.engine.dynamics.cells import extremes

# Entries of ``PairList.clock``: steps since the list was built, and the steepest slope (1/s) of the
# profile of ``PairList.stream`` over height.
AGE, SLOPE = range(2)

#: Particles that a layer must hold for its mean velocity to count.
ENOUGH = 4


@inlined
def _layer_means(height, speed, lowest, thickness, at, mean):
    """Fill ``at`` and ``mean`` with mean height and speed of all layers that hold enough particles.

    Returns how many do.
    """
    count = np.zeros(at.size)
    for i in range(height.size):
        layer = min(int((height[i] - lowest) / thickness), at.size - 1)
        count[layer] += 1.0
        at[layer] += height[i]
        mean[layer] += speed[i]
    known = 0
    for layer in range(at.size):
        if count[layer] >= ENOUGH:
            at[known], mean[known] = at[layer] / count[layer], mean[layer] / count[layer]
            known += 1
    return known


@inlined
def set_stream(pairs, height, speed):
    """Take the flow's profile along x: straight lines between the means of layers of one diameter.

    Fills ``pairs.stream`` with each particle's velocity in that profile, relative to the mean of
    all (m/s). ``height`` (m) and ``speed`` (m/s) are those of the particles.
    """
    lowest, highest = extremes(height)
    layers = min(int((highest - lowest) / pairs.largest) + 1, height.size)
    at, mean = np.zeros(layers), np.zeros(layers)
    known = _layer_means(height, speed, lowest, pairs.largest, at, mean)
    steepest, overall, k = 0.0, speed.mean(), 0
    for layer in range(known - 1):
        slope = (mean[layer + 1] - mean[layer]) / (at[layer + 1] - at[layer])
        steepest = max(steepest, abs(slope))
    for i in range(height.size):
        while k < known - 2 and height[i] > at[k + 1]:
            k += 1
        while k > 0 and height[i] < at[k]:
            k -= 1
        pairs.stream[i] = 0.0
        if known > 1:
            share = (height[i] - at[k]) / (at[k + 1] - at[k])
            rise = mean[k + 1] - mean[k]
            pairs.stream[i] = mean[k] + min(max(share, 0.0), 1.0) * rise - overall
    pairs.clock[SLOPE] = steepest


@inlined
def allowed_stray(pairs, time_step):
    """Return how far (m) particles may stray from the flow before the list must be rebuilt.

    A shear by ε shortens no distance by more than the factor √(1 + ε²/4) - ε/2. What then remains
    of a distance of one reach and a skin, beyond the reach, is shared by two partners.
    """
    strain = pairs.clock[SLOPE] * pairs.clock[AGE] * time_step
    factor = sqrt(1.0 + 0.25 * strain * strain) - 0.5 * strain
    return max(0.0, 0.5 * ((pairs.largest + pairs.skin) * factor - pairs.largest))
