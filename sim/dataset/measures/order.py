"""Order of spheres: shares in a crystal, and layers parallel to the plane."""

import numpy as np

#: What makes a sphere crystalline: at least 8 neighbors within 1.4 diameters whose surroundings are
#: turned as its own, that is with a product of normalised q6 vectors above 0.7
#: (ten Wolde, Ruiz-Montero and Frenkel, J. Chem. Phys. 104 (1996) 9932).
DEGREE, COHERENT, BONDS, REACH = 6, 0.7, 8, 1.4

#: Distances between layers that are tried, in diameters: those of crystals under their weight.
SPACINGS = np.linspace(0.7, 1.05, 71)


def coherent_bonds(position: np.ndarray, side: float, diameter: float) -> np.ndarray:
    """Return how many coherent q6 bonds each sphere has, (N,).

    Parameters
    ----------
    position : (N, 3) array
        Centres, m; the cell of length ``side`` (m) is periodic along x and y alone.
    diameter : float
        Mean diameter, m.
    """
    import freud

    height = position[:, 2] - 0.5 * (position[:, 2].min() + position[:, 2].max())
    box = freud.box.Box(side, side, np.ptp(height) + 4 * REACH * diameter)
    box.periodic = (True, True, False)
    # The library takes single precision, so positions are first brought into the cell.
    centred = box.wrap(np.column_stack([position[:, :2] - 0.5 * side, height]))
    order = freud.order.SolidLiquid(l=DEGREE, q_threshold=COHERENT, solid_threshold=BONDS)
    # Processes that read run files side by side share the cores among them.
    with freud.parallel.NumThreads(1):
        order.compute((box, centred.astype(np.float32)), neighbors={"r_max": REACH * diameter})
    return order.num_connections


def crystalline_share(
    position: np.ndarray, chosen: np.ndarray, side: float, diameter: float
) -> float:
    """Return the share of chosen spheres with at least 8 coherent bonds, NaN if none is chosen.

    Those not chosen count as neighbors.
    """
    if not chosen.any():
        return np.nan
    return float((coherent_bonds(position, side, diameter)[chosen] >= BONDS).mean())


def layer_order(height: np.ndarray, diameter: float) -> float:
    """Return how strongly centres at heights (N,), m, gather in equidistant layers, 0 to 1.

    The amplitude A of the wave exp(2πi z/d) in their density at the distance d that suits best:
    the density by layers peaks at 1 + 2A of its mean. 1 is perfect layers, 1/√N about no order.
    """
    if not height.size:
        return np.nan
    waves = np.exp(2j * np.pi * height[:, None] / (SPACINGS * diameter))
    return float(np.abs(waves.mean(axis=0)).max())
