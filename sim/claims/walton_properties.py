"""Judges of Walton's claims about what the spheres are like: order, restitution, stiffness."""

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import above, below, within
from sim.claims.chute import CELLS, of_settled, repeated, speed
from sim.claims.evidence import Evidence
from sim.claims.place import Place, quotient
from sim.claims.trends import ordered
from sim.claims.verdict import Check, Untestable
from sim.dataset.measures import layers

#: Depths with crystals, and the least share of crystalline spheres and amplitude of layers there.
CRYSTALLINE, SHARE, LAYERED = (10, 20, 40), 0.5, 0.25

#: Depth, cell and controls that are to weaken the order.
CONTROLLED, SPREAD = {"depth": 10, "cell": 5}, 0.1

#: Depths at which the restitution is varied: of those with three values each.
RESILIENT = (5, 10, 20, 40)

#: Overlaps in the paper's words, and the factor that "on the order of" leaves.
STATIC, DYNAMIC, SLIGHT, ORDER = 0.005, 0.05, 0.005, 2

#: Depths that depend on the stiffness and those that do not, stiffnesses that decide it, and bounds
#: of the ratio of velocities.
SENSITIVE: tuple[float, ...] = (20, 40)
INSENSITIVE, SOFT, STIFF = (1.24, 2.5), 100, 1000
SLOWER, EQUAL = 0.9, 0.05

#: Heights in diameters of the layers above the bottom one.
ABOVE_BOTTOM = (1, 5)


def w15(evidence: Evidence) -> list[Check]:
    """Share of crystalline spheres and layers of the plug, and the share under three controls.

    Controls: unequal spheres, spheres glued to the plane, and a wider cell, all at one depth.
    """
    deep = {n: evidence.at("chute", depth=n) for n in CRYSTALLINE}
    checks = []
    for n, place in deep.items():
        share, order = place.value("crystalline_share"), place.value("layer_order")
        checks.append(above(f"crystalline share of the plug, n = {n:g}", share, SHARE, [place]))
        checks.append(above(f"amplitude of its layers, n = {n:g}", order, LAYERED, [place]))
    usual, controls = evidence.at("chute", **CONTROLLED), _controls(evidence)
    for name, place in controls.items():
        change = place.value("crystalline_share") - usual.value("crystalline_share")
        what = f"change of the crystalline share with {name}, n = {CONTROLLED['depth']:g}"
        checks.append(below(what, change, 0, [place, usual]))
    return of_settled(checks, [*deep.values(), usual, *controls.values()])


def _controls(evidence: Evidence) -> dict[str, Place]:
    """Return the flows that differ from the crystalline one in one respect."""
    bumpy = {size: place for size, place in _line(evidence, "bumps").items() if size > 0}
    if not bumpy:
        raise Untestable("no flow over a bumpy plane")
    size, rough = max(bumpy.items())
    wide = CONTROLLED | {"cell": 2 * CONTROLLED["cell"]}
    return {
        f"diameters ±{100 * SPREAD:g} %": evidence.at(
            "chute", diameter_spread=SPREAD, **CONTROLLED
        ),
        f"bumps of {size:g} σ": rough,
        f"a cell of {wide['cell']:g} σ": evidence.at("chute", **wide),
    }


def _line(evidence: Evidence, along: str) -> dict[float, Place]:
    return evidence.line("chute", along, **CONTROLLED)


def w16(evidence: Evidence) -> list[Check]:
    """Velocity and shear depth along the restitution, at each depth with three values of it."""
    checks = []
    for n in RESILIENT:
        line = repeated(evidence.line("chute", "restitution", depth=n, cell=CELLS[n]))
        if len(line) < 3:
            continue
        at = f"n = {n:g}, e"
        speeds = {e: speed(place) for e, place in line.items()}
        depths = {e: place.value("shear_depth") for e, place in line.items()}
        found = ordered("V", at, speeds, line, rising=False)
        found += ordered("shear depth", at, depths, line, rising=True)
        checks += of_settled(found, line.values())
    if not checks:
        raise Untestable("no depth with three coefficients of restitution that have replicates")
    return checks


def w20(evidence: Evidence) -> list[Check]:
    """Quantiles of the overlaps of the softest spheres, within a factor of two of the paper's."""
    deep = evidence.at("chute", depth=40, stiffness=SOFT)

    def check(what: str, place: Place, name: str, size: float) -> Check:
        percent = 100 * place.value(name)
        bounds = 100 * size / ORDER, 100 * size * ORDER
        return within(f"{what}, n = {place['depth']:g}", percent, *bounds, [place], "% of σ")

    thin = [evidence.at("chute", depth=n, stiffness=SOFT) for n in INSENSITIVE]
    checks = [
        check("median overlap", deep, "median_overlap", STATIC),
        check("99.9th percentile of the overlaps", deep, "overlap_999", DYNAMIC),
        *(check("99.9th percentile of the overlaps", one, "overlap_999", SLIGHT) for one in thin),
    ]
    return of_settled(checks, [deep, *thin])


def w21(evidence: Evidence) -> list[Check]:
    """Velocity and shear depth of stiffer spheres over those of the softest, deep and shallow."""
    checks = []
    for n in SENSITIVE:
        for stiffness, soft, stiff in _stiffer(evidence, n):
            at, places = f"K1 = {stiffness:g} N/m over {SOFT} N/m, n = {n:g}", [soft, stiff]
            ratio = quotient(speed(stiff), speed(soft))
            deeper = quotient(stiff.value("shear_depth"), soft.value("shear_depth"))
            found = [
                below(f"V at {at}", ratio, SLOWER, places),
                above(f"shear depth at {at}", deeper, 1, places),
            ]
            checks += of_settled(found, places)
    for n in INSENSITIVE:
        for stiffness, soft, stiff in _stiffer(evidence, n):
            what = f"V at K1 = {stiffness:g} N/m over {SOFT} N/m, n = {n:g}"
            ratio = quotient(speed(stiff), speed(soft))
            check = within(what, ratio, 1 - EQUAL, 1 + EQUAL, [soft, stiff])
            checks += of_settled([check], [soft, stiff])
    return checks


def w22(evidence: Evidence) -> list[Check]:
    """Vertical granular temperature of four layers above the bottom one, stiffer over softest."""
    checks = []
    for n in SENSITIVE:
        for stiffness, soft, stiff in _stiffer(evidence, n):
            ratio = quotient(_agitation(stiff), _agitation(soft))
            what = f"vertical temperature at K1 = {stiffness:g} N/m over {SOFT} N/m, n = {n:g}"
            checks += of_settled([above(what, ratio, 1, [soft, stiff])], [soft, stiff])
    return checks


def _stiffer(evidence: Evidence, depth: float) -> list[tuple[float, Place, Place]]:
    """Return stiffnesses above the softest, with the places of the softest and of theirs.

    Raises `Untestable` where there is none with ten times the stiffness.
    """
    line = evidence.line("chute", "stiffness", depth=depth)
    if SOFT not in line or STIFF not in line:
        raise Untestable(f"no flows with K1 = {SOFT} and {STIFF} N/m at n = {depth:g}")
    return [(value, line[SOFT], place) for value, place in line.items() if value >= STIFF]


def _agitation(place: Place) -> UFloat:
    """Return the vertical granular temperature (m²/s²) above the bottom layer."""
    low, high = (bound * place["diameter"] for bound in ABOVE_BOTTOM)

    def mean(height: np.ndarray, temperature: np.ndarray, packing: np.ndarray) -> float:
        return layers.mean_between(height, temperature, packing, low, high)

    return place.measure(mean, "vertical_temperature_profile", "packing_profile")
