"""How long a neighbor list stays valid: displacements measured against the mean flow.

A pair that is not in the list can come into contact only when its partners approach each other. The
common motion of all particles brings none together, and a flow whose velocity changes with height
brings pairs together only as fast as the steepest slope of its profile shears them. Displacements
therefore count relative to that flow, and the list of a fast flow lives several times longer.
"""

from math import sqrt

import numpy as np

from sim.engine.compile import inlined
from sim.engine.dynamics.cells import extremes

# Entries of ``PairList.clock``: steps since the list was built, and the steepest slope (1/s) of the
# profile of ``PairList.stream`` over height.
AGE, SLOPE = range(2)

#: Particles that a layer must hold for its mean velocity to count.
LEAST_PARTICLES = 4


@inlined
def _layer_means(height, speed, lowest, thickness, mean_height, mean_speed):
    """Fill ``mean_height`` and ``mean_speed`` of all layers that hold enough particles.

    Returns the number of these layers.
    """
    count = np.zeros(mean_height.size)
    for i in range(height.size):
        layer = min(int((height[i] - lowest) / thickness), mean_height.size - 1)
        count[layer] += 1.0
        mean_height[layer] += height[i]
        mean_speed[layer] += speed[i]
    layers = 0
    for layer in range(mean_height.size):
        if count[layer] >= LEAST_PARTICLES:
            mean_height[layers], mean_speed[layers] = (
                mean_height[layer] / count[layer],
                mean_speed[layer] / count[layer],
            )
            layers += 1
    return layers


@inlined
def set_stream(pairs, height, speed):
    """Set the flow's profile along x: straight lines between the means of layers of one diameter.

    Fills ``pairs.stream`` with each particle's velocity in that profile, relative to the mean of
    all (m/s). ``height`` (m) and ``speed`` (m/s) are those of the particles.
    """
    lowest, highest = extremes(height)
    layers = min(int((highest - lowest) / pairs.largest) + 1, height.size)
    mean_height, mean_speed = np.zeros(layers), np.zeros(layers)
    full_layers = _layer_means(height, speed, lowest, pairs.largest, mean_height, mean_speed)
    steepest, overall, k = 0.0, speed.mean(), 0
    for layer in range(full_layers - 1):
        slope = (mean_speed[layer + 1] - mean_speed[layer]) / (
            mean_height[layer + 1] - mean_height[layer]
        )
        steepest = max(steepest, abs(slope))
    for i in range(height.size):
        while k < full_layers - 2 and height[i] > mean_height[k + 1]:
            k += 1
        while k > 0 and height[i] < mean_height[k]:
            k -= 1
        pairs.stream[i] = 0.0
        if full_layers > 1:
            share = (height[i] - mean_height[k]) / (mean_height[k + 1] - mean_height[k])
            rise = mean_speed[k + 1] - mean_speed[k]
            pairs.stream[i] = mean_speed[k] + min(max(share, 0.0), 1.0) * rise - overall
    pairs.clock[SLOPE] = steepest


@inlined
def allowed_stray(pairs, time_step):
    """Return how far (m) particles may stray from the flow before the list must be rebuilt.

    A shear by ε shortens no distance by more than the factor √(1 + ε²/4) - ε/2. Two partners share
    what then remains of one reach plus skin, beyond the reach.
    """
    strain = pairs.clock[SLOPE] * pairs.clock[AGE] * time_step
    factor = sqrt(1.0 + 0.25 * strain * strain) - 0.5 * strain
    return max(0.0, 0.5 * ((pairs.largest + pairs.skin) * factor - pairs.largest))
