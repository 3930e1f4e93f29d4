"""Order of spheres: share in crystals, and layers parallel to the plane."""

import numpy as np

#: A sphere is crystalline if it has at least 8 coherent bonds: neighbors within 1.4 diameters whose
#: normalised q6 vector has a product with its own above 0.7 (similar surroundings, similarly
#: oriented; ten Wolde, Ruiz-Montero and Frenkel, J. Chem. Phys. 104 (1996) 9932).
DEGREE, COHERENCE, MIN_BONDS, BOND_LENGTH = 6, 0.7, 8, 1.4

#: Trial distances between layers, in diameters: those of crystals under their own weight.
SPACINGS = np.linspace(0.7, 1.05, 71)


def coherent_bonds(position: np.ndarray, side: float, diameter: float) -> np.ndarray:
    """Return the number of coherent q6 bonds of each sphere, (N,).

    Parameters
    ----------
    position : (N, 3) array
        Centres, m; the cell of length ``side`` (m) is periodic along x and y only.
    diameter : float
        Mean diameter, m.
    """
    import freud

    height = position[:, 2] - 0.5 * (position[:, 2].min() + position[:, 2].max())
    box = freud.box.Box(side, side, np.ptp(height) + 4 * BOND_LENGTH * diameter)
    box.periodic = (True, True, False)
    # Positions are wrapped into the cell first, because the library takes single precision.
    centred = box.wrap(np.column_stack([position[:, :2] - 0.5 * side, height]))
    order = freud.order.SolidLiquid(l=DEGREE, q_threshold=COHERENCE, solid_threshold=MIN_BONDS)
    # One thread: processes that read run files in parallel share the cores.
    with freud.parallel.NumThreads(1):
        order.compute(
            (box, centred.astype(np.float32)), neighbors={"r_max": BOND_LENGTH * diameter}
        )
    return order.num_connections


def crystalline_share(
    position: np.ndarray, is_selected: np.ndarray, side: float, diameter: float
) -> float:
    """Return the share of selected spheres with at least 8 coherent bonds, NaN without any.

    The other spheres count as neighbors.
    """
    if not is_selected.any():
        return np.nan
    return float((coherent_bonds(position, side, diameter)[is_selected] >= MIN_BONDS).mean())


def layer_order(height: np.ndarray, diameter: float) -> float:
    """Return how strongly centres at heights (N,), m, gather in equidistant layers, 0 to 1.

    It is the amplitude A of the wave exp(2πi z/d) in their density, at the distance d with the
    largest amplitude. The density peaks at 1 + 2A times its mean. Perfect layers give 1, and no
    order gives about 1/√N.
    """
    if not height.size:
        return np.nan
    waves = np.exp(2j * np.pi * height[:, None] / (SPACINGS * diameter))
    return float(np.abs(waves.mean(axis=0)).max())
