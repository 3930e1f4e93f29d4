"""Judges of Walton's claims about profiles: where flows shear, how dense they are, their plugs."""

from collections.abc import Callable, Mapping
from itertools import pairwise

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import above, below, reported
from sim.claims.chute import base, of_settled, repeated
from sim.claims.evidence import Evidence
from sim.claims.place import Place, joined, quotient
from sim.claims.trends import least, mean_of_others
from sim.claims.verdict import Check, Untestable
from sim.dataset.measures import layers

#: Bins with less than this share of the mass do not count.
THIN = 0.01

#: Replicates without which a statement about all bins at once cannot be decided.
MANY = 6

#: Depths of each claim: all below 5 and 2.5, intermediate, with a plug, the deepest.
SHALLOW, SHALLOWEST, MIDDLE, DEEP, DEEPEST = 5, 2.5, (3.5, 5, 10), (10, 20, 40), 40

#: Least share of the depth that a plug takes.
PLUG = 0.3

#: Least packing of the plug, its largest relative spread, least difference from the shear layer.
DENSE, UNIFORM, LOOSER = 0.60, 0.05, 0.05

#: Least share of the largest du/dz that a flow which shears throughout has everywhere.
THROUGHOUT = 0.2


def w10(evidence: Evidence) -> list[Check]:
    """Steps of the velocity from each slice with 1 % of the mass to the next; all bins at once."""
    flows = _thin(evidence, SHALLOW)
    checks = (
        above(
            f"least du/dz, n = {n:g}", least(_steps(place, "velocity_profile")), 0, [place], "1/s"
        )
        for n, place in flows.items()
    )
    return of_settled(checks, flows.values())


def w11(evidence: Evidence) -> list[Check]:
    """Share of the depth above the height where du/dz falls below 5 % of that below it."""
    names, flows = ("velocity_profile", "packing_profile"), _deep(evidence, DEEP)
    checks = (
        above(
            f"plug over depth, n = {n:g}", place.measure(_plug_share(place), *names), PLUG, [place]
        )
        for n, place in flows.items()
    )
    return of_settled(checks, flows.values())


def w12(evidence: Evidence) -> list[Check]:
    """Steps of the packing from each layer of a diameter to the next; all of them at once.

    Slices thinner than a sphere show the gap between layers as well; their largest step from the
    first centres upwards is reported.
    """
    flows = _thin(evidence, SHALLOWEST)
    checks = []
    for n, place in flows.items():
        layered = np.diff(_by_layers(place), axis=1)
        sliced = _steps(place, "packing_profile", 0.5 * place["diameter"], 1.0)
        if not layered.size:
            raise Untestable(f"fewer than two layers at n = {n:g}")
        what = "largest rise of the packing with height"
        checks += [
            below(f"{what}, by layers, n = {n:g}", -least(-layered), 0, [place]),
            reported(f"{what}, by slices, n = {n:g}", -least(-sliced), [place]),
        ]
    return of_settled(checks, flows.values())


def w13(evidence: Evidence) -> list[Check]:
    """Packing by layers of a diameter: the densest inner one against the lowest and the highest."""
    flows = {n: place for n, place in repeated(base(evidence)).items() if n in MIDDLE}
    if len(flows) < len(MIDDLE):
        raise Untestable("no flows at n = 3.5, 5 and 10 that have replicates")
    checks = []
    for n, place in flows.items():
        rows = _by_layers(place)
        if len(rows) < 2 or rows.shape[1] < 3:
            raise Untestable(f"fewer than three layers, or than two replicates, at n = {n:g}")
        for name, end in (("lowest", 0), ("highest", -1)):
            what = f"packing of the densest inner layer less that of the {name}, n = {n:g}"
            checks.append(above(what, joined(_densest_inner(rows) - rows[:, end]), 0, [place]))
    return of_settled(checks, flows.values())


def _densest_inner(rows: np.ndarray) -> np.ndarray:
    """Return the packing (R) of the densest inner layer of layers (R, L).

    Which one it is, is told by all other replicates, see `mean_of_others`.
    """
    chosen = 1 + mean_of_others(rows)[:, 1:-1].argmax(axis=1)
    return rows[np.arange(len(rows)), chosen]


def w14(evidence: Evidence) -> list[Check]:
    """The deepest flow above and below its shear depth: packing, its spread, the difference."""
    ((n, place),) = _deep(evidence, (DEEPEST,)).items()

    def measured(function: Callable[[np.ndarray, float], float]) -> UFloat:
        return place.measure(_of_plug(place, function), "velocity_profile", "packing_profile")

    checks = [
        above(
            f"packing of the plug, n = {n:g}", measured(lambda plug, _: plug.mean()), DENSE, [place]
        ),
        below(
            f"relative spread of its packing, n = {n:g}",
            measured(lambda plug, _: np.ptp(plug) / plug.mean()),
            UNIFORM,
            [place],
        ),
        above(
            f"packing of the plug less that of the shear layer, n = {n:g}",
            measured(lambda plug, sheared: plug.mean() - sheared),
            LOOSER,
            [place],
        ),
    ]
    return of_settled(checks, [place])


def w17(evidence: Evidence) -> list[Check]:
    """Shear depths of successive deep flows, the deeper over the shallower."""
    flows = _deep(evidence, DEEP)
    depths = {n: place.value("shear_depth") for n, place in flows.items()}
    checks = (
        below(
            f"shear depth at n = {high:g} over that at n = {low:g}",
            quotient(depths[high], depths[low]),
            1,
            [flows[low], flows[high]],
        )
        for low, high in pairwise(DEEP)
    )
    return of_settled(checks, flows.values())


def w18(evidence: Evidence) -> list[Check]:
    """The slowest flow: least over largest mean du/dz over a diameter."""
    flows = repeated(base(evidence, 1))
    if len(flows) < 3:
        raise Untestable("fewer than three flows with n ≥ 1 that have replicates")
    n, place = min(flows.items(), key=lambda flow: flow[1].velocity.nominal_value)
    evenness = place.measure(_evenness(place), "velocity_profile", "packing_profile")
    check = above(f"least over largest du/dz, n = {n:g}", evenness, THROUGHOUT, [place])
    return of_settled([check], [place])


def _thin(evidence: Evidence, below_depth: float) -> dict[float, Place]:
    """Return the flows of less than a depth, from one layer on, with many replicates."""
    flows = {n: place for n, place in base(evidence, 1).items() if n < below_depth}
    found = repeated(flows, MANY)
    if not found:
        raise Untestable(f"no flow with 1 ≤ n < {below_depth:g} that has {MANY} replicates")
    return found


def _deep(evidence: Evidence, depths: tuple[float, ...]) -> Mapping[float, Place]:
    """Return the flows of these depths; raise `Untestable` where one is missing."""
    return {n: evidence.at("chute", depth=n) for n in depths}


def _steps(place: Place, name: str, lowest: float = 0.0, scale: float | None = None) -> np.ndarray:
    """Return the steps (R, B) of a profile between slices with 1 % of the mass, over ``scale``.

    Without a scale they are slopes. Slices below ``lowest`` (m) do not count.
    """
    (rows, height), (packing, _) = place.profile(name), place.profile("packing_profile")
    mean = packing.mean(axis=0)
    counted = (mean > THIN * mean.sum()) & (height >= lowest)
    return np.diff(rows[:, counted], axis=1) / (scale or np.diff(height[counted]))


def _by_layers(place: Place) -> np.ndarray:
    """Return the packing by layers of a diameter (R, L), of those that all replicates have."""
    packing, height = place.profile("packing_profile")
    rows = [layers.packing_by_diameters(height, row, place["diameter"]) for row in packing]
    return np.array([row[: min(map(len, rows))] for row in rows])


def _evenness(place: Place) -> Callable[..., float]:
    """Return the function of profiles that gives the least over the largest mean du/dz.

    The means are over a diameter, because a slice shares its spheres with its neighbors.
    """

    def evenness(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        across = round(place["diameter"] / (height[1] - height[0]))
        counted = velocity[packing > THIN * packing.sum()]
        slopes = counted[across:] - counted[:-across]
        rises = slopes.size > 1 and slopes.max() > 0
        return slopes.min() / slopes.max() if rises else np.nan

    return evenness


def _plug_share(place: Place) -> Callable[..., float]:
    """Return the function of profiles that says which share of the depth is plug."""

    def share(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        plug = layers.plug_base(height, velocity, packing, place["diameter"])
        return 1.0 - plug / layers.surface(height, packing)

    return share


def _of_plug(place: Place, function: Callable[[np.ndarray, float], float]) -> Callable[..., float]:
    """Return a function of profiles: of the packing by layers of the plug, and of what it rides on.

    Layers of two diameters, because those of a crystal are no diameter apart. The gap under the
    centres of the lowest spheres belongs to no layer.
    """
    diameter = place["diameter"]

    def measure(height: np.ndarray, velocity: np.ndarray, packing: np.ndarray) -> float:
        depth = layers.shear_depth(height, velocity, packing, diameter)
        rows = layers.packing_by_diameters(height, packing, diameter, layers=2)
        plug = rows[2 * diameter * np.arange(len(rows)) >= depth]
        sheared = packing[(height >= 0.5 * diameter) & (height < depth)]
        return function(plug, sheared.mean()) if plug.size and sheared.size else np.nan

    return measure
